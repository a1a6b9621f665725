// Commands: each shows its outcome, and what is missing where it may not be given.
import { signal } from "@preact/signals";
import { call } from "./door.js";
import { html } from "./html.js";

/** What the last command led to: text, and whether it succeeded; null for none. */
export const outcome = signal(null);

const SWITCHED = new Set(["light", "plug", "switch", "fan", "on_off_light", "on_off_plug", "outlet"]);

export async function command(device, word, values = []) {
  outcome.value = { text: `${device.name}: ${word === "set" ? "…" : `${word} …`}`, isGood: true };
  try {
    const answer = await call("/devices/command", { target: device.id, command: word, values });
    const found = answer.results.map((one) => `${one.name}: ${one.result.text}`).join("; ");
    outcome.value = { text: found || `${device.name}: ${answer.message}`, isGood: answer.success };
  } catch (error) {
    outcome.value = { text: `${device.name}: ${error.message}`, isGood: false };
  }
}

/** The button that turns a device on or off; nothing for other devices. */
export function Acting({ device }) {
  const isOn = [...device.states.values()].find((one) => one.capability === "on_off")?.value;
  if (typeof isOn !== "boolean" || !SWITCHED.has(device.type)) return null;
  const word = isOn ? "off" : "on";
  return html`<button type="button" aria-label=${`turn ${device.name} ${word}`} onClick=${() => command(device, word)}>
    ${word}
  </button>`;
}
