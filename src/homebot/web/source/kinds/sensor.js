// What only reports: hazards, motion, people, and numbers.
import { act } from "../acts.js";
import { read, readingOf, takes } from "../house.js";
import { say } from "../language.js";
import { summary, valueText, wordsOf } from "../words.js";

const HAZARDS = ["smoke", "carbon_monoxide_alarm", "gas", "water_leak", "freeze", "heat", "safety", "tamper"];
const LOW = 10; // per cent of a battery

const isWrong = (device) => HAZARDS.some((one) => read(device, one) === true);

/** The word of a flag, such as wet or dry; a weak battery before it says that all is well. */
function hazardState(device) {
  const reading = HAZARDS.map((one) => readingOf(device, one)).find((one) => one?.value) ?? HAZARDS.map((one) => readingOf(device, one)).find(Boolean);
  if (!isWrong(device) && read(device, "battery") < LOW) return say("battery {value}", { value: valueText("battery", read(device, "battery")) });
  return reading ? say((wordsOf(reading.capability) ?? ["no", "yes"])[Number(reading.value)]) : summary(device) || say("unknown");
}

export const hazard = {
  types: ["smoke_co_alarm", "water_leak_detector", "water_freeze_detector"],
  group: "others",
  isActive: isWrong,
  tone: (device) => (isWrong(device) ? "alarm" : "rest"),
  state: hazardState,
  main: [],
};

export const motion = {
  types: ["occupancy_sensor"],
  group: "others",
  isActive: (device) => read(device, "occupancy") === true,
  tone: (device) => (read(device, "occupancy") ? "on" : "rest"),
  state: (device) => valueText("occupancy", read(device, "occupancy")),
  main: [],
};

/** What tells events and pictures, and has no state. */
const EVENTFUL = new Set(["camera", "generic_switch", "x_tag", "x_tag_reader"]);
/** What is pressed. */
const PRESSED = ["push", "scene", "press"];

export const plain = {
  types: [],
  group: "others",
  isActive: (device) => ["on_off", "at_home", "update_available"].some((one) => read(device, one) === true),
  tone: (device) => (isWrong(device) ? "alarm" : "rest"),
  state: (device) => summary(device) || (device.settable.length || EVENTFUL.has(device.type) ? "" : say("unknown")),
  act(device) {
    const pressed = PRESSED.find((one) => takes(device, one));
    return pressed && !device.states.size ? act("press", "press", pressed, true) : null;
  },
  main: [],
};
