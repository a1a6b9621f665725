// What is switched: plugs, fans, pumps, sirens, and what has no kind of its own.
import { act, setting } from "../acts.js";
import { read, takes } from "../house.js";
import { say } from "../language.js";
import { Pillar } from "../pillar.js";
import { html } from "../html.js";
import { valueText } from "../words.js";

const IDLE = 5; // watts of what is on and rests

const isOn = (device) => read(device, "on_off") ?? (read(device, "fan_speed") ?? 0) > 0;
const speed = (device) => (takes(device, "fan_speed") ? (isOn(device) ? Math.round(read(device, "fan_speed") ?? 100) : 0) : null);
/** What the value of a device that is on is told by. */
const TOLD = ["power", "fan_speed", "level"];

function state(device) {
  const told = TOLD.find((capability) => read(device, capability) !== undefined);
  return !isOn(device) ? say("off") : told ? valueText(told, Math.round(read(device, told))) : say("on");
}

export const switched = {
  types: ["plug", "switch", "fan", "pump", "siren"],
  group: "others",
  isActive: isOn,
  isSwitch: true,
  tone: (device) => (isOn(device) && (read(device, "power") ?? IDLE) >= IDLE ? "on" : "rest"),
  state,
  level: speed,
  act: (device) => takes(device, "on_off") && act(isOn(device) ? "turn off" : "turn on", isOn(device) ? "off" : "on", "on_off", !isOn(device)),
  slide: (value) => setting("", "fan_speed", value),
  Main: ({ device }) => html`<${Pillar} device=${device} level=${speed(device)} isOn=${isOn(device)} />`,
  main: ["on_off", "fan_speed"],
};
