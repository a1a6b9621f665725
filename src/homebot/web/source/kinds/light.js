// Lights: on or off, how bright, and which white, color or effect.
import { act, setting } from "../acts.js";
import { read, takes } from "../house.js";
import { say } from "../language.js";
import { Pillar } from "../pillar.js";
import { Swatches } from "../swatches.js";
import { html } from "../html.js";
import { valueText } from "../words.js";

const isOn = (device) => read(device, "on_off") ?? (read(device, "level") ?? 0) > 0;
const level = (device) => (takes(device, "level") ? (isOn(device) ? Math.round(read(device, "level") ?? 100) : 0) : null);

export const light = {
  types: ["light"],
  group: "lights",
  isActive: isOn,
  isSwitch: true,
  tone: (device) => (isOn(device) ? "lit" : "rest"),
  state: (device) => (!isOn(device) ? say("off") : read(device, "level") === undefined ? say("on") : valueText("level", Math.round(read(device, "level")))),
  level,
  act: (device) => act(isOn(device) ? "turn off" : "turn on", isOn(device) ? "off" : "on", "on_off", !isOn(device)),
  slide: (value) => setting("", "level", value),
  Main: ({ device }) => html`<${Pillar} device=${device} level=${level(device)} isOn=${isOn(device)} /><${Swatches} device=${device} />`,
  main: ["on_off", "level", "color_temperature", "color", "effect"],
};
