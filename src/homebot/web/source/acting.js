// Commands: each shows its outcome, and what is missing where it may not be given.
import { signal } from "@preact/signals";
import { call, missing } from "./door.js";
import { say } from "./language.js";
import { outcomeText, spoken } from "./words.js";

const SHOWN = 8000; // ms for which an outcome is shown

/** What the last command led to: text, and whether it succeeded; null for none. */
export const outcome = signal(null);

export async function command(device, word, values = [], code = "") {
  tell(`${device.name}: ${word === "set" ? "…" : `${say(`${word}|do`)} …`}`, true);
  try {
    const answer = await call("/devices/command", { target: device.id, command: word, values, code });
    missing.value = answer.results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
    const found = answer.results.map((one) => `${spoken(one.name)}: ${outcomeText(one.result)}`).join("; ");
    tell(found || `${device.name}: ${answer.message}`, answer.success);
  } catch (error) {
    tell(`${device.name}: ${error.message}`, false);
  }
}

let hiding = 0;

/** Show what a command led to. */
export function tell(text, isGood) {
  clearTimeout(hiding);
  outcome.value = { text, isGood };
  if (isGood) hiding = setTimeout(() => (outcome.value = null), SHOWN);
}
