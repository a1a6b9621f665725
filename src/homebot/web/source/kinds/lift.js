// Lifts: a button for each floor, the highest first.
import { Choice } from "../buttons.js";
import { html } from "../html.js";
import { useOptions } from "../options.js";
import { plain } from "./sensor.js";

function Main({ device }) {
  return html`<${Choice} device=${device} capability="floor" options=${useOptions(device, "floor").toReversed()} />`;
}

export const lift = { ...plain, types: ["x_lift"], Main, main: ["floor"] };
