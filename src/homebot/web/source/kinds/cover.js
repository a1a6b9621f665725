// What opens and closes: blinds and shutters, garage doors and gates, windows with a motor, valves.
import { act, setting } from "../acts.js";
import { ActButton, Amount } from "../buttons.js";
import { read, takes } from "../house.js";
import { html } from "../html.js";
import { SIGNS } from "../icons.js";
import { say } from "../language.js";
import { valueText } from "../words.js";

const MOVES = new Set(["opening", "closing"]);
const SLATS = [["tilt", "slats"]];

const capabilityOf = (device) => ["movement", "position", "valve"].find((one) => takes(device, one) || read(device, one) !== undefined) ?? "movement";
const movement = (device) => read(device, "movement") ?? read(device, "valve");
const position = (device) => read(device, "position");
export const isClosed = (device) => (position(device) ?? (movement(device) === "closed" ? 0 : 1)) === 0 && !MOVES.has(movement(device));

function state(device) {
  if (MOVES.has(movement(device))) return say(movement(device));
  const at = position(device);
  if (at > 0 && at < 100) return say("{value} open", { value: valueText("position", Math.round(at)) });
  return movement(device) === undefined && at === undefined ? say("unknown") : say(isClosed(device) ? "closed" : "open");
}

const opening = (device) => act("open", "open", capabilityOf(device), true);
const closing = (device) => act("close", "close", capabilityOf(device));

function mainAct(device) {
  if (!["movement", "position", "valve"].some((one) => takes(device, one))) return null;
  if (MOVES.has(movement(device)) && takes(device, "movement")) return act("stop", "stop", "movement");
  return (position(device) ?? (isClosed(device) ? 0 : 100)) < 50 ? opening(device) : closing(device);
}

/** The opening as a picture, buttons beside it, and the slats. */
function Main({ device }) {
  const at = position(device) ?? (isClosed(device) ? 0 : 100);
  const guarded = device.asks_first.includes(capabilityOf(device));
  const steps = [["up", opening(device)], ...(takes(device, "movement") ? [["stop", act("stop", "stop", "movement")]] : []), ["down", closing(device)]];
  return html`<div class="cover">
      <span class="pane" aria-hidden="true"><span style=${{ blockSize: `${100 - at}%` }}></span></span>
      <div class="column">${mainAct(device) && steps.map(([sign, own]) => html`<${ActButton} key=${sign} device=${device} act=${own} sign=${SIGNS[sign]} />`)}</div>
    </div>
    ${!guarded && takes(device, "position") && html`<${Amount} device=${device} capability="position" text=${say("open")} />`}
    ${SLATS.filter(([one]) => takes(device, one)).map(([one, text]) => html`<${Amount} key=${one} device=${device} capability=${one} text=${say(text)} />`)}`;
}

const Turned = ({ device }) => html`<div class="solo">${[opening(device), closing(device)].map((own) => html`<${ActButton} key=${own.text} device=${device} act=${own} />`)}</div>`;

export const cover = {
  types: ["window_covering"],
  group: "covers",
  isActive: (device) => !isClosed(device),
  tone: (device) => (MOVES.has(movement(device)) ? "on" : "rest"),
  state,
  level: (device) => (takes(device, "position") && !device.asks_first.includes("position") ? Math.round(position(device) ?? 0) : null),
  act: mainAct,
  slide: (value) => setting("", "position", value),
  Main,
  main: ["movement", "position", "tilt"],
};

export const closure = { ...cover, types: ["closure"], group: "doors", tone: (device) => (isClosed(device) ? "rest" : "open"), level: () => null };

export const valve = { ...cover, types: ["water_valve"], group: "others", tone: (device) => (isClosed(device) ? "rest" : "on"), level: () => null, Main: Turned, main: ["valve", "position"] };
