// Commands: each shows its outcome, and what is missing where it may not be given.
import { signal } from "@preact/signals";
import { call, missing } from "./door.js";
import { html } from "./html.js";
import { outcomeText } from "./words.js";

const SHOWN = 8000; // ms for which an outcome is shown

/** What the last command led to: text, and whether it succeeded; null for none. */
export const outcome = signal(null);

const SWITCHED = new Set(["light", "plug", "switch", "fan", "on_off_light", "on_off_plug", "outlet"]);

export async function command(device, word, values = [], code = "") {
  tell(`${device.name}: ${word === "set" ? "…" : `${word} …`}`, true);
  try {
    const answer = await call("/devices/command", { target: device.id, command: word, values, code });
    missing.value = answer.results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
    const found = answer.results.map((one) => `${one.name}: ${outcomeText(one.result)}`).join("; ");
    tell(found || `${device.name}: ${answer.message}`, answer.success);
  } catch (error) {
    tell(`${device.name}: ${error.message}`, false);
  }
}

/** The switch that turns a device on or off; nothing for other devices. */
export function Switch({ device }) {
  const isOn = [...device.states.values()].find((one) => one.capability === "on_off")?.value;
  if (typeof isOn !== "boolean" || !SWITCHED.has(device.type)) return null;
  return html`<button type="button" class="switch" role="switch" aria-checked=${String(isOn)} aria-label=${device.name} onClick=${() => command(device, isOn ? "off" : "on")}></button>`;
}

let hiding = 0;

function tell(text, isGood) {
  clearTimeout(hiding);
  outcome.value = { text, isGood };
  if (isGood) hiding = setTimeout(() => (outcome.value = null), SHOWN);
}
