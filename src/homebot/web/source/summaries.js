// What the house is like, in few words: for chips, rooms, and the views of security, climate and energy.
import { computed } from "@preact/signals";
import { deviceOf, floors, isHidden, read, readingOf, rooms, shown } from "./house.js";
import { thingOf } from "./icons.js";
import { isPerson, kindOf, toneOf } from "./kinds.js";
import { say } from "./language.js";
import { isKept, layout, roomKey, usage } from "./layout.js";
import { titled, valueText } from "./words.js";

export const OUTSIDE = /outside|outdoor|garden|balcon|terrace|au(ß|ss)en|draußen|garten|extérieur|exterior|jardin|jardín|buiten|tuin|esterno|giardino/i;

export const isOpen = (device) => toneOf(device) === "open";
export const isLightOn = (device) => device.type === "light" && kindOf(device).isActive(device);

/** The rooms, each with its devices: first as the owner orders them, then by floor, use and name; that without a name last. */
export const allRooms = computed(() => {
  const own = layout.value.rooms.map((one) => one.toLowerCase());
  const found = rooms.value.map(([room, ids]) => [room, ids.filter((id) => !isHidden(id)).map((id) => deviceOf(id)?.value).filter((one) => one && !isPerson(one))]).filter(([, devices]) => devices.length);
  const key = ([room, devices]) => [room === "", (own.indexOf(room.toLowerCase()) + 1) || Infinity, floors.value.get(room.toLowerCase()) ?? "\uffff", -devices.reduce((sum, one) => sum + usage.value.total(one.id), 0)];
  const keyed = found.map((row) => [key(row), row]);
  keyed.sort(([a], [b]) => [0, 1, 2, 3].map((at) => (a[at] < b[at] ? -1 : a[at] > b[at] ? 1 : 0)).find(Boolean) ?? 0);
  return keyed.map(([, row]) => row);
});
export const roomList = computed(() => allRooms.value.filter(([room]) => !isKept("hidden", roomKey(room))));

/** People; where homebot knows none, what each of them carries. */
export const people = computed(() => ["x_person", "x_tracker"].map((type) => shown.value.filter((one) => one.type === type)).find((found) => found.length) ?? []);
export const isAtHome = (person) => read(person, "at_home") ?? read(person, "place") === "home";

/** Each capability that tells a temperature of the air, the best first. */
const TEMPERATURES = ["local_temperature", "temperature"];
const AIR = new Set(["thermostat", "room_air_conditioner", "temperature_sensor", "air_quality_sensor", "humidity_sensor", "occupancy_sensor"]);

/** The mean of a value of the air of some devices; undefined without one. */
export function airOf(devices, capabilities = TEMPERATURES) {
  const found = devices.filter((one) => AIR.has(one.type) && toneOf(one) !== "silent").map((one) => capabilities.map((name) => read(one, name)).find((value) => typeof value === "number")).filter((value) => value !== undefined);
  return found.length ? found.reduce((sum, value) => sum + value, 0) / found.length : undefined;
}
export const temperatureText = (value) => valueText("temperature", Math.round(10 * value) / 10);

/** Whether a device is outside, by words of its name and room. */
export const isOutside = (device) => OUTSIDE.test(`${device.room} ${device.name}`);

/** What a door or window is called on its own: in a house of many windows with its room. */
export const placeName = (device) => (device.room && !device.name.toLowerCase().includes(device.room.toLowerCase()) && /^(window|door|fenster|tür|fenêtre|porte|ventana|puerta|raam|deur|finestra|porta)$/i.test(device.name) ? `${titled(device.room)}: ${device.name}` : device.name);

export const openText = (open) => (open.length ? say(open[0].type === "door_lock" ? "{name} unlocked" : "{name} open", { name: placeName(open[0]) }) + (open.length > 1 ? `, +${open.length - 1}` : "") : say("all closed"));

/** What opens, of those that are open: a door before a window. */
export const openOf = (devices) => devices.filter(isOpen).sort((a, b) => (thingOf(a) === "window") - (thingOf(b) === "window"));

/** Whether a device is the meter of the house, which counts the others too, by the owner's tag. */
export const isHouseMeter = (device) => Boolean(device?.tags.includes("house meter"));
/** Those that are counted in a sum: the meter of the house alone, where there is one. */
export const counted = (rows, isWhole = isHouseMeter) => (rows.some(isWhole) ? rows.filter(isWhole) : rows);

/** Watts that are drawn now. */
export const powerOf = (devices) => counted(devices.filter((one) => readingOf(one, "power") && toneOf(one) !== "silent")).reduce((sum, one) => sum + Math.max(0, read(one, "power")), 0);
