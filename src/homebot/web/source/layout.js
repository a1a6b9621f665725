// The owner's order, the same on every screen, and what people use at this time of day. Nothing moves under a finger: what
// another screen changed waits until nobody touches this one.
import { signal } from "@preact/signals";
import { tell } from "./acts.js";
import { now, zone } from "./clock.js";
import { ask, call, subscribe } from "./door.js";
import { sayReason } from "./language.js";

const CALM = 3000; // ms after a touch in which nothing moves
const HOURS = 24;

/** Ids of devices in `favorites`, `hidden` and `not_here`, rooms by their names in `rooms`, and `icons` by either. */
export const layout = signal({ favorites: [], hidden: [], not_here: [], rooms: [], icons: [], undoes: "" });

/** The key of a room among hidden things and icons. */
export const roomKey = (room) => `room:${room}`;
export const iconOf = (key) => layout.value.icons.find((one) => one.key === key)?.value ?? "";
export const isKept = (list, key) => layout.value[list].includes(key);

let touched = -Infinity;
let waiting = 0;
for (const kind of ["pointerdown", "keydown"]) addEventListener(kind, () => (touched = performance.now()), true);

/** For how many milliseconds nobody has touched this screen, since it was opened. */
export const untouched = () => performance.now() - touched;

subscribe("/page/layout", function take(told) {
  clearTimeout(waiting);
  const left = CALM - untouched();
  if (left > 0) waiting = setTimeout(() => take(told), left);
  else layout.value = told;
});

/** Change the layout for all screens, here at once. */
export async function changeLayout(change, args = {}) {
  const answer = await ask("/page/change_layout", { change, ...args });
  if (answer.layout && answer.success) {
    clearTimeout(waiting);
    layout.value = answer.layout;
  }
  if (answer.message) tell(sayReason(answer.message), false);
}

export const keep = (list, key, isIn) => changeLayout(isIn ? "add" : "remove", { list, names: [key] });

let counted = new Map(); // by device: the commands of people in each hour of the day

/** Ask what people use; it counts from the next visit on. */
export async function askUsage() {
  const { devices } = await call("/page/usage").catch(() => ({ devices: null }));
  if (devices) counted = new Map(devices.map((one) => [one.device, one.hours]));
}

/** How much each device is used, in all and about this hour, as of the last visit of Home: between visits nothing moves. */
export const usage = signal({ total: () => 0, atThisHour: () => 0 });

export function beginVisit() {
  const hour = Number(new Intl.DateTimeFormat("en", { hour: "numeric", hourCycle: "h23", timeZone: zone.value }).format(now() * 1000));
  const hours = counted;
  usage.value = {
    total: (id) => hours.get(id)?.reduce((sum, one) => sum + one, 0) ?? 0,
    atThisHour: (id) => [hour - 1, hour, hour + 1].reduce((sum, at) => sum + (hours.get(id)?.[(at + HOURS) % HOURS] ?? 0), 0),
  };
}
