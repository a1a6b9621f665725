// Commands: each shows its outcome, and what is missing where it may not be given.
import { signal } from "@preact/signals";
import { call, missing } from "./door.js";
import { say } from "./language.js";
import { outcomeText, spoken } from "./words.js";

const SHOWN = 8000; // ms for which an outcome is shown

/** What the last command led to: text, whether it succeeded, and what commands it over a lease, if one forbids it. */
export const outcome = signal(null);

export async function command(device, word, values = [], code = "", override = false) {
  tell(`${device.name}: ${word === "set" ? "…" : `${say(`${word}|do`)} …`}`, true);
  try {
    const answer = await call("/devices/command", { target: device.id, command: word, values, code, override });
    missing.value = answer.results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
    const found = answer.results.map((one) => `${spoken(one.name)}: ${outcomeText(one.result)}`).join("; ");
    const isHeld = answer.results.some((one) => one.result.policy === "lease");
    const again = isHeld && !override ? () => command(device, word, values, code, true) : null;
    tell(found || `${device.name}: ${answer.message}`, answer.success, again);
  } catch (error) {
    tell(`${device.name}: ${error.message}`, false);
  }
}

let hiding = 0;

/** Show what a command led to. */
export function tell(text, isGood, override = null) {
  clearTimeout(hiding);
  outcome.value = { text, isGood, override };
  if (isGood) hiding = setTimeout(() => (outcome.value = null), SHOWN);
}
