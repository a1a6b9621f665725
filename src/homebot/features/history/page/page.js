import { html } from "../../html.js";
import { SIGNS } from "../../icons.js";
import { later } from "../../later.js";
import { powerOf } from "../../summaries.js";
import { valueText } from "../../words.js";

/** The power of now, among the chips of Home. */
const EnergyChip = ({ devices, Chip }) =>
  devices.some((one) => [...one.states.values()].some((reading) => reading.capability === "power")) && html`<${Chip} view="energy" sign=${SIGNS.energy} text=${valueText("power", Math.round(powerOf(devices)))} tone="on" />`;

export const page = {
  views: { energy: { title: "Energy", View: later(async () => (await import("./energy.js")).Energy), after: "climate", hasHead: true } },
  parts: { chips: EnergyChip, day: later(async () => (await import("./mini.js")).Mini), device: later(async () => (await import("./history.js")).History) },
};
