// Acts: a command shows that it was given, and its outcome in words if it was not confirmed. What lets in, floods or
// burns is held for a second on every way to it; and homebot says of each other command whether it asks first.
import { signal } from "@preact/signals";
import { call, missing } from "./door.js";
import { say, sayReason } from "./language.js";
import { label, outcomeText, spoken, valueText } from "./words.js";

const SHOWN = 4000; // ms for which an outcome is shown

/** What the last command led to: text, whether it succeeded, and what commands it over a lease, if one forbids it. */
export const outcome = signal(null);

/** What is done once a person agrees: its text, and the function that does it; null for nothing. */
export const agreement = signal(null);

/** The devices that have not answered yet, with what they were told. */
export const pending = signal(new Map());

/** Ask whether to do what *text* says. */
export function agree(text, act) {
  outcome.value = null;
  agreement.value = { text, act };
}

/** An act by a word of a command, which sets *capability*; *opens* where it may let in, flood or burn. */
export const act = (text, word, capability, opens = false) => ({ text, word, capability, opens, values: [] });

/** An act that sets a value. */
export const setting = (text, capability, value, opens = false) => ({ text, word: "set", capability, opens, values: [{ key: capability, value: String(value) }] });

/** Which code an act needs: digits, text, or none. */
export const codeOf = (device, { capability }) => device.codes.find((one) => one.key === capability)?.value ?? "";

/** Whether an act is held before it is done. */
export const isGuarded = (device, own) => own.opens && (device.asks_first.includes(own.capability) || Boolean(codeOf(device, own)));

/** Do an act of a device; *isHeld* where a person held it, or confirmed it by keys. */
export const perform = (device, { word, values }, { isHeld = false, code = "" } = {}) => command(device, word, values, code, isHeld);

export const command = (device, word, values = [], code = "", isHeld = false) => send(device, { target: device.id, command: word, values, code, unless_asks: !isHeld });

async function send(device, asked) {
  const { command: word, values } = asked;
  const told = word === "set" ? values.map((one) => `${label(one.key)} ${one.value}`).join(", ") : say(`${word}|do`);
  const [id] = device.id.split("#");
  agreement.value = null;
  outcome.value = null;
  pending.value = new Map(pending.value).set(id, word === "set" ? valuesText(values) : told);
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
    tell(found || `${device.name}: ${sayReason(answer.message)}`, answer.success, again);
  } catch (error) {
    tell(`${device.name}: ${sayReason(error.message)}`, false);
  } finally {
    const left = new Map(pending.value);
    left.delete(id);
    pending.value = left;
  }
}

const valuesText = (values) => values.map(({ key, value }) => (value === "" || Number.isNaN(Number(value)) ? label(value) : valueText(key, Number(value)))).join(", ");

let hiding = 0;

/** Show what a command led to. */
export function tell(text, isGood, override = null) {
  clearTimeout(hiding);
  outcome.value = { text, isGood, override };
  if (isGood) hiding = setTimeout(() => (outcome.value = null), SHOWN);
}
