// The language of the page: the browser's, or the one that was chosen here. A row of the table is an English text in the others.
import { effect, signal } from "@preact/signals";
import table from "./languages.json" with { type: "json" };

export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français", es: "Español", nl: "Nederlands", it: "Italiano" };

const COLUMNS = ["de", "fr", "es", "nl", "it"];
const CHOICE = "homebot.language";

export const language = signal([localStorage.getItem(CHOICE), ...navigator.languages].map((one) => one?.slice(0, 2)).find((one) => one in LANGUAGES) ?? "en");

effect(() => (document.documentElement.lang = language.value));

export function choose(name) {
  localStorage.setItem(CHOICE, name);
  language.value = name;
}

/** An English text in the language of the page, with values for its {names}; what follows a | tells equal texts apart. */
export function say(text, values = {}) {
  const found = table[text]?.[COLUMNS.indexOf(language.value)] ?? text.split("|")[0];
  return found.replace(/\{(\w+)\}/g, (all, name) => values[name] ?? all);
}

export const numberText = (value) => value.toLocaleString(language.value, { maximumFractionDigits: 20, useGrouping: false });
