// The language of the page: the browser's, or the one that was chosen here. A row of the table is an English text in the others.
import { computed, effect, signal } from "@preact/signals";
import { keyOf } from "./text_key.js";
export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français", es: "Español", nl: "Nederlands", it: "Italiano" };

/** Each language is loaded when it is chosen: its texts, and the forms of homebot's reasons in English. */
const LOADERS = { de: () => import("./languages/de.js"), es: () => import("./languages/es.js"), fr: () => import("./languages/fr.js"), it: () => import("./languages/it.js"), nl: () => import("./languages/nl.js") };
const ENGLISH = { texts: {}, reasons: [] };
const CHOICE = "homebot.language";

const first = [localStorage.getItem(CHOICE), ...navigator.languages].map((one) => one?.slice(0, 2)).find((one) => one in LANGUAGES) ?? "en";
const tableOf = async (name) => (await LOADERS[name]?.().catch(() => {})) ?? ENGLISH; // English, where homebot is away

let table = await tableOf(first);
let patterns = patternsOf(table);

export const language = signal(first);

/** The name by which browsers know how the language is written here, such as en-GB. */
export const locale = computed(() => navigator.languages.find((one) => one.startsWith(language.value)) ?? language.value);

effect(() => (document.documentElement.lang = language.value));

export async function choose(name) {
  localStorage.setItem(CHOICE, name);
  table = await tableOf(name);
  patterns = patternsOf(table);
  language.value = name;
}

/** An English text in the language of the page, with values for its {names}; an ending after | tells equal texts apart. */
export function say(text, values = {}) {
  const found = (language.value === "en" ? null : table.texts[keyOf(text)]) ?? text.replace(/\|\w+$/, "");
  return found.replace(/\{(\w+)\}/g, (all, name) => values[name] ?? all);
}

function patternsOf({ reasons }) {
  return reasons.map((text) => [text, new RegExp(`^${text.replace(/\{(\w+)\}/g, "(?<$1>.+?)")}$`)]);
}

/** A reason that homebot gives in English, in the language of the page if it has one of the forms of the table. */
export function sayReason(text) {
  const [form, found] = patterns.map(([one, pattern]) => [one, pattern.exec(text)]).find(([, one]) => one) ?? [text];
  const { value, reason, ...others } = found?.groups ?? {};
  return say(form, { ...others, value: say(value ?? ""), reason: reason && sayReason(reason) });
}

export const numberText = (value) => value.toLocaleString(locale.value, { maximumFractionDigits: 20, useGrouping: false });
