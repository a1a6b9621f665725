// Commands: each shows its outcome, and what is missing where it may not be given. What always asks is done once the
// person at the page agrees: homebot says what asks, so that no way to a command on the page can leave that out.
import { signal } from "@preact/signals";
import { call, missing } from "./door.js";
import { say } from "./language.js";
import { label, outcomeText, spoken } from "./words.js";

const SHOWN = 8000; // ms for which an outcome is shown

/** What the last command led to: text, whether it succeeded, and what commands it over a lease, if one forbids it. */
export const outcome = signal(null);

/** What is done once a person agrees: its text, and the function that does it; null for nothing. */
export const agreement = signal(null);

/** Ask whether to do what *text* says. */
export function agree(text, act) {
  outcome.value = null;
  agreement.value = { text, act };
}

export const command = (device, word, values = [], code = "") => send(device, { target: device.id, command: word, values, code, unless_asks: true });

async function send(device, asked) {
  const { command: word, values } = asked;
  const told = word === "set" ? values.map((one) => `${label(one.key)} ${one.value}`).join(", ") : say(`${word}|do`);
  agreement.value = null;
  tell(`${device.name}: ${word === "set" ? "…" : `${told} …`}`, true);
  try {
    const answer = await call("/devices/command", asked);
    if (answer.asks.length) {
      const reasons = answer.asks.map((one) => `${spoken(one.key)} (${one.value})`).join(", ");
      agree(`${told}: ${reasons}`, () => send(device, { ...asked, unless_asks: false }));
      return;
    }
    missing.value = answer.results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
    const found = answer.results.map((one) => `${spoken(one.name)}: ${outcomeText(one.result)}`).join("; ");
    const isHeld = answer.results.some((one) => one.result.policy === "lease");
    const again = isHeld && !asked.override ? () => send(device, { ...asked, override: true }) : null;
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
