// Vacuums and lawn mowers: start, pause, back to the dock; and robots, which go by the plan.
import { perform, setting } from "../acts.js";
import { read, takes } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { say } from "../language.js";
import { useOptions } from "../options.js";
import { textOf, valueText } from "../words.js";

const WORKS = new Set(["cleaning", "mowing", "spot"]);
const BUTTONS = [["start", "play", "cleaning", "mowing"], ["pause", "pause", "paused"], ["return to dock", "dock", "returning"]];

const isMower = (device) => device.type === "x_lawn_mower";
const capabilityOf = (device) => (isMower(device) ? "mower" : "vacuum");
const stateOf = (device) => read(device, capabilityOf(device));
const startWord = (device) => (isMower(device) ? "mowing" : "cleaning");

function Main({ device }) {
  const capability = capabilityOf(device);
  const options = useOptions(device, capability);
  return html`<div class="media">${BUTTONS.map(([text, sign, ...words]) => [text, sign, words[Number(isMower(device))] ?? words[0]])
    .filter(([, , word]) => options.includes(word))
    .map(([text, sign, word]) => html`<button key=${word} type="button" class=${sign === "play" ? "chief" : ""} aria-label=${say(text)} onClick=${() => perform(device, setting(text, capability, word))}><${Sign} path=${SIGNS[sign]} size=${28} /></button>`)}</div>`;
}

const worker = {
  group: "others",
  isActive: (device) => WORKS.has(stateOf(device)),
  tone: (device) => (stateOf(device) === "error" ? "alarm" : WORKS.has(stateOf(device)) ? "on" : "rest"),
  state: (device) => [stateOf(device) ? textOf(capabilityOf(device), stateOf(device)) : say("unknown"), read(device, "battery") !== undefined && valueText("battery", read(device, "battery"))].filter(Boolean).join(" · "),
  act: (device) => takes(device, capabilityOf(device)) && (WORKS.has(stateOf(device)) ? setting("pause", capabilityOf(device), "paused") : setting("start", capabilityOf(device), startWord(device))),
  Main,
};

export const vacuum = { ...worker, types: ["robotic_vacuum_cleaner"], main: ["vacuum"] };
export const mower = { ...worker, types: ["x_lawn_mower"], main: ["mower"] };
