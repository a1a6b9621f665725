// The language of the page: the browser's, or the one that was chosen here. A row of the table is an English text in the others.
import { computed, effect, signal } from "@preact/signals";
import texts from "./languages.json" with { type: "json" };
import reasons from "./reasons.json" with { type: "json" };

const table = { ...texts, ...reasons };

export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français", es: "Español", nl: "Nederlands", it: "Italiano" };

const COLUMNS = ["de", "fr", "es", "nl", "it"];
const CHOICE = "homebot.language";

export const language = signal([localStorage.getItem(CHOICE), ...navigator.languages].map((one) => one?.slice(0, 2)).find((one) => one in LANGUAGES) ?? "en");

/** The name by which browsers know how the language is written here, such as en-GB. */
export const locale = computed(() => navigator.languages.find((one) => one.startsWith(language.value)) ?? language.value);

effect(() => (document.documentElement.lang = language.value));

export function choose(name) {
  localStorage.setItem(CHOICE, name);
  language.value = name;
}

/** An English text in the language of the page, with values for its {names}; an ending after | tells equal texts apart. */
export function say(text, values = {}) {
  const found = table[text]?.[COLUMNS.indexOf(language.value)] ?? text.replace(/\|\w+$/, "");
  return found.replace(/\{(\w+)\}/g, (all, name) => values[name] ?? all);
}

const REASONS = Object.keys(reasons).map((text) => [text, new RegExp(`^${text.replace(/\{(\w+)\}/g, "(?<$1>.+?)")}$`)]);

/** A reason that homebot gives in English, in the language of the page if it has one of the forms of the table. */
export function sayReason(text) {
  const [form, found] = REASONS.map(([one, pattern]) => [one, pattern.exec(text)]).find(([, one]) => one) ?? [text];
  const { value, reason, ...others } = found?.groups ?? {};
  return say(form, { ...others, value: say(value ?? ""), reason: reason && sayReason(reason) });
}

export const numberText = (value) => value.toLocaleString(locale.value, { maximumFractionDigits: 20, useGrouping: false });
