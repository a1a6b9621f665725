// Values, times and causes as people read them.
import { computed, signal } from "@preact/signals";
import { now, zone } from "./clock.js";
import { locale, numberText, say, sayReason } from "./language.js";

/** Of capabilities: units, words for no and yes, and texts that only report; and the outcomes that are failures. */
export const vocabulary = signal({ units: {}, failures: [], flags: {}, passing: {} });

export async function loadVocabulary() {
  const answer = await fetch("vocabulary.json");
  if (answer.ok) vocabulary.value = await answer.json();
}

/** A name as people say it: kitchen_lamp, which is a name for programs, is "Kitchen lamp"; others are as they are. */
export const spoken = (name) => (/^[a-z]+(_[a-z0-9]+)+$/.test(name) ? name[0].toUpperCase() + name.slice(1).replaceAll("_", " ") : name);

/** The name of a room as a title. */
export const titled = (name) => spoken(name).replace(/^./u, (first) => first.toUpperCase());

/** A text with a capital at its begin. */
export const capital = (text) => text.replace(/^./u, (first) => first.toLocaleUpperCase(locale.value));

const TOLD = ["alarm", "lock", "mower", "movement", "place", "thermostat_action", "vacuum", "valve"];
/** Capabilities with texts of the vocabulary. */
const SPOKEN = new Set([...TOLD, "direction", "playback", "thermostat_mode"]);
/** Capabilities whose value needs no name beside it. */
const PLAIN = new Set([...TOLD, "floor", "value", "state", "scan", "press"]);
/** Those of the summary too, as the unit tells the capability. */
const BY_UNIT = new Set(["level", "position", "temperature", "local_temperature", "illuminance", "power", "energy", "voltage", "current"]);
/** Capabilities that only the name of their part tells. */
export const UNNAMED = new Set(["measurement", "number", "option", "state", "text", "value"]);
/** Values of a device that its summary leaves out, if it has the other one. */
const TOLD_BY = { thermostat_mode: "thermostat_action", temperature: "local_temperature" };
const SHORT = { heating_setpoint: "set to {value}", cooling_setpoint: "cooled to {value}", humidity_setpoint: "set to {value}" };

/** A number as people say it, in the steps of its device where they are known: 40.16 % is 40 %. */
export function roundedTo(value, unit, step = 0) {
  const near = Math.abs(value);
  const digits = [0, 1, 2].find((one) => step && Math.abs(step * 10 ** one - Math.round(step * 10 ** one)) < 1e-6);
  const usual = unit === "%" ? (near > 0 && near < 1 ? 1 : 0) : near < 10 && unit !== "°C" ? 2 : 1;
  return Number(value.toFixed(unit === "%" ? Math.min(digits ?? usual, 1) : (digits ?? usual)));
}

/** A value of a capability, with its unit, in steps of that number. */
export function valueText(capability, value, unit = "", step = 0) {
  if (value === null || value === undefined) return say("unknown");
  if (typeof value === "boolean") return say((wordsOf(capability) ?? ["no", "yes"])[Number(value)]);
  if (typeof value === "number") {
    const own = unit || vocabulary.value.units[capability] || "";
    const text = numberText(roundedTo(value, own, step));
    return own ? `${text}\u00a0${own}` : text;
  }
  return Array.isArray(value) ? value.map((one) => Math.round(one)).join(", ") : textOf(capability, String(value));
}

/** Names that are written otherwise. */
const WRITTEN = { floor: "floor|lift", on_off: "on/off", pm1: "PM1", pm10: "PM10", pm25: "PM2.5" };

/** The name of a capability, a type or a count, as text. */
export const label = (name) => say(WRITTEN[name] ?? name.replace(/^x_/, "").replaceAll("_", " "));

/** A moment as programs write it, such as when a picture was taken. */
const MOMENT = /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:?\d\d)$/;

/** A text of a capability, as people write it; a device's own texts are left as they are. */
export function textOf(capability, text) {
  if (MOMENT.test(text)) return timeText({ sec: Date.parse(text) / 1000, nanosec: 0 });
  return SPOKEN.has(capability) ? say(text.replaceAll("_", " ") + (capability === "thermostat_mode" ? "|mode" : "")) : text;
}

/** The unit of a capability: of the device, else of the vocabulary. */
export const unitOf = (capability) => capability.unit || vocabulary.value.units[capability.name] || "";

/** The words of a capability for 0 and 1; undefined if it has none. */
export const wordsOf = (capability) => vocabulary.value.flags[capability];

/** The values of a device in one line, the most telling first, without one that is shown elsewhere. */
export function summary(device, shown) {
  const found = [...device.states.values()].filter((one) => one.value !== null && one !== shown);
  const has = (name, value) => found.some((one) => one.capability === name && (value === undefined || one.value === value));
  const isTold = ({ capability, value }) =>
    capability.startsWith("color") ||
    (capability === "level" && has("on_off", false)) ||
    (capability === "state" && has("on_off")) ||
    (capability === "measurement" && found.some((one) => BY_UNIT.has(one.capability))) ||
    (capability === "position" && has("movement", value === 100 ? "open" : value === 0 ? "closed" : "")) ||
    has(TOLD_BY[capability]);
  const isFirst = (one) => (PLAIN.has(one.capability) || typeof one.value === "boolean" ? 0 : 1);
  return found
    .filter((one) => !isTold(one))
    .sort((a, b) => isFirst(a) - isFirst(b))
    .slice(0, 4)
    .map((one) => {
      const unit = device.units?.find(({ key }) => key === `${one.part} ${one.capability}`)?.value;
      return UNNAMED.has(one.capability) || BY_UNIT.has(one.capability) || SHORT[one.capability] ? say(SHORT[one.capability] ?? "{value}", { value: valueText(one.capability, one.value, unit) }) : readingText(one, unit);
    })
    .join(" · ");
}

/** Whether a device is on, open or occupied. */
export const isActive = (device) =>
  [...device.states.values()].some((one) => (["on_off", "contact", "occupancy"].includes(one.capability) ? one.value === true : one.capability === "movement" && one.value !== "closed"));

/** Return whether a text has all words that are sought, in any case. */
export const hasWords = (text, sought) => sought.toLowerCase().split(" ").every((word) => text.toLowerCase().includes(word));

export const seconds = (time) => time.sec + time.nanosec / 1e9;
export const clock = computed(() => new Intl.DateTimeFormat(locale.value, { hour: "2-digit", minute: "2-digit", second: "2-digit", hour12: false, timeZone: zone.value }));
export const day = computed(() => new Intl.DateTimeFormat(locale.value, { month: "short", day: "numeric", timeZone: zone.value }));
export const hour = computed(() => new Intl.DateTimeFormat(locale.value, { hour: "2-digit", minute: "2-digit", hour12: false, timeZone: zone.value }));

/** Since when something is so, for a tile: hours and minutes of today, else the day; empty where it is unknown. */
export function sinceText(time) {
  const at = time ? seconds(time) : 0;
  if (!at) return "";
  return day.value.format(at * 1000) === day.value.format(now() * 1000) ? hour.value.format(at * 1000) : day.value.format(at * 1000);
}

/** A moment: the time of today, else day and time; empty for none. */
export function timeText(time) {
  const at = seconds(time);
  if (!at) return "";
  const date = new Date(at * 1000);
  const text = clock.value.format(date);
  const isToday = Math.abs(now() - at) < 90_000 && day.value.format(date) === day.value.format(now() * 1000); // a day may have 25 hours
  return isToday ? text : `${day.value.format(date)} ${text}`;
}

/** A moment in a time zone, which is named; in that of the browser, if it does not know the zone. */
export function timeIn(zone, time) {
  const date = new Date(seconds(time) * 1000);
  const format = { weekday: "short", month: "short", day: "numeric", hour: "2-digit", minute: "2-digit", hour12: false, timeZoneName: "short" };
  try {
    return date.toLocaleString(locale.value, { ...format, timeZone: zone || undefined });
  } catch {
    return date.toLocaleString(locale.value, format);
  }
}

/** A length of time, in its two largest units. */
export function durationText(length) {
  if (length < 1) return `${Math.max(1, Math.round(length * 1000))} ms`;
  if (length < 10) return `${numberText(Number(length.toFixed(1)))} s`;
  const units = [["d", 86_400], ["h", 3600], ["min", 60], ["s", 1]];
  const first = units.findIndex(([, size]) => length >= size);
  let rest = length;
  return units
    .slice(first, first + 2)
    .map(([name, size]) => {
      const many = Math.floor(rest / size);
      rest -= many * size;
      return many ? `${many} ${name}` : "";
    })
    .filter(Boolean)
    .join(" ");
}

export const settingsText = (settings) => settings.map((one) => readingText(one)).join(", ");

const readingText = (one, unit = "") =>
  (PLAIN.has(one.capability) || typeof one.value === "boolean" ? "" : `${label(one.capability)} `) + valueText(one.capability, one.value, unit);

/** What was seen instead of what was commanded, such as "level is 20". */
const seenText = (text) => sayReason(text).replace(/(\w+) is ([^,]+)/g, (all, capability, value) => readingText({ capability, value: wordsOf(capability) ? value === "on" : Number.isNaN(Number(value)) ? value : Number(value) }));

/** What became of a command. */
const OUTCOMES = {
  already_so: "it was so already",
  confirmed: "confirmed after {time}",
  contradicted: "contradicted: {saw}",
  gone: "the device was removed",
  no_answer: "no answer within {time}",
  refused: "refused ({policy}): {reason}",
  reverted: "changed back after {time}",
  superseded: "superseded by a newer command",
};

/** The text of an outcome, with its time as people read it. */
export function outcomeText(result) {
  if (result.outcome === "no_answer" && result.reason) return sayReason(`not sent: ${result.reason}`);
  const known = OUTCOMES[result.outcome];
  if (!known) return result.text;
  return say(known, { ...result, policy: label(result.policy), saw: seenText(result.saw ?? ""), reason: sayReason(result.reason), time: durationText(result.latency) });
}
