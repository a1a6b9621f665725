// The kinds of devices, by their type: each has a module, with its tone, state, level, main act and main control.
import { alarm } from "./kinds/alarm.js";
import { climate, humidifier } from "./kinds/climate.js";
import { closure, cover, valve } from "./kinds/cover.js";
import { contact, lock } from "./kinds/door.js";
import { lift } from "./kinds/lift.js";
import { light } from "./kinds/light.js";
import { media } from "./kinds/media.js";
import { mower, vacuum } from "./kinds/robot.js";
import { hazard, motion, plain } from "./kinds/sensor.js";
import { switched } from "./kinds/switch.js";
import { isThing, thingOf, thingSigns } from "./icons.js";
import { readingOf } from "./house.js";
import { say } from "./language.js";
import { iconOf } from "./layout.js";
import { capital, sinceText } from "./words.js";

const KINDS = new Map([alarm, climate, closure, contact, cover, hazard, humidifier, lift, light, lock, media, motion, mower, switched, vacuum, valve].flatMap((kind) => kind.types.map((type) => [type, kind])));

/** Types that a room shows only when asked for, and those that are no tiles. */
const ASIDE = new Set(["x_scene", "x_setting", "x_battery", "x_update", "generic_switch", "x_tag", "x_tag_reader", "x_unknown"]);
const PEOPLE = new Set(["x_person", "x_tracker", "x_household"]);

/** Values since when an open or occupied device is so. */
const SINCE = ["contact", "lock", "movement"];

export const kindOf = (device) => KINDS.get(device.type) ?? plain;

export const isPerson = ({ type }) => PEOPLE.has(type);
export const isAside = ({ type }) => ASIDE.has(type);

/** Why a device is not known now; empty where it is. */
export const silenceOf = (device) => (!device.is_reachable ? say("unreachable") : device.freshness === "stale" ? say("silent") : "");

/** What its color says. */
export const toneOf = (device) => (silenceOf(device) ? "silent" : kindOf(device).tone(device));

export const signOf = (device) => thingSigns(isThing(iconOf(device.id)) ? iconOf(device.id) : thingOf(device))[kindOf(device).isActive(device) ? 0 : 1];

/** The state of a device in words, since when it is open where that is known. */
export function stateOf(device) {
  const silence = silenceOf(device);
  const text = kindOf(device).state(device);
  if (silence) return [capital(silence), text].filter(Boolean).join(" · ");
  const since = toneOf(device) === "open" ? sinceText(SINCE.map((one) => readingOf(device, one)).find(Boolean)?.since) : "";
  return capital(since ? say("{state} since {time}", { state: text, time: since }) : text);
}
