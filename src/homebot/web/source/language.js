// The language of the page: the browser's, or the one that was chosen here. A row of the table is an English text in the others.
import { computed, effect, signal } from "@preact/signals";
import { keyOf } from "./text_key.js";
export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français", es: "Español", nl: "Nederlands", it: "Italiano" };

/** Each language is loaded when it is chosen: what the first views say. */
const LOADERS = { de: () => import("./languages/de.js"), es: () => import("./languages/es.js"), fr: () => import("./languages/fr.js"), it: () => import("./languages/it.js"), nl: () => import("./languages/nl.js") };
const LATE = { de: () => import("./languages/de_late.js"), es: () => import("./languages/es_late.js"), fr: () => import("./languages/fr_late.js"), it: () => import("./languages/it_late.js"), nl: () => import("./languages/nl_late.js") };
const ENGLISH = { texts: "" };
export const SOON = 2000; // ms after which the rest is loaded in any case
const CHOICE = "homebot.language";

const first = [localStorage.getItem(CHOICE), ...navigator.languages].map((one) => one?.slice(0, 2)).find((one) => one in LANGUAGES) ?? "en";
const tableOf = async (name) => (await LOADERS[name]?.().catch(() => {})) ?? ENGLISH; // English, where homebot is away

/** Texts by their keys: the keys, of three letters, are the first line. */
function byKey(lines) {
  const [keys, ...texts] = lines.split("\n");
  return new Map(texts.map((text, at) => [keys.slice(3 * at, 3 * at + 3), text]));
}

const table = signal(byKey((await tableOf(first)).texts));
let patterns = [];
let rest = null;

/** Load the rest of the language: the texts of later views, and the forms of reasons. */
export const loadRest = () => (rest ??= addRest(language.value).catch(() => (rest = null)));

async function addRest(name) {
  const { texts, reasons } = (await LATE[name]?.()) ?? { ...ENGLISH, reasons: [] };
  if (name !== language.value) return;
  patterns = patternsOf(reasons);
  table.value = new Map([...table.value, ...byKey(texts)]);
}
setTimeout(loadRest, SOON);

export const language = signal(first);

/** The name by which browsers know how the language is written here, such as en-GB. */
export const locale = computed(() => navigator.languages.find((one) => one.startsWith(language.value)) ?? language.value);

effect(() => (document.documentElement.lang = language.value));

export async function choose(name) {
  localStorage.setItem(CHOICE, name);
  table.value = byKey((await tableOf(name)).texts);
  [patterns, rest] = [[], null];
  language.value = name;
  await loadRest();
}

/** An English text in the language of the page, with values for its {names}; an ending after | tells equal texts apart. */
export function say(text, values = {}) {
  const own = language.value === "en" ? "" : table.value.get(keyOf(text));
  if (own === undefined) loadRest(); // a first view shows what few do, such as an alert
  const found = own || text.replace(/\|\w+$/, "");
  return found.replace(/\{(\w+)\}/g, (all, name) => values[name] ?? all);
}

function patternsOf(reasons) {
  return reasons.map((text) => [text, new RegExp(`^${text.replace(/[().?]/g, "\\$&").replace(/\{(\w+)\}/g, "(?<$1>.+?)")}$`)]);
}

/** A reason that homebot gives in English, in the language of the page if it has one of the forms of the table. */
export function sayReason(text) {
  const [form, found] = patterns.map(([one, pattern]) => [one, pattern.exec(text)]).find(([, one]) => one) ?? [text];
  const { value, reason, list, ...others } = found?.groups ?? {};
  return say(form, { ...others, value: say(value ?? ""), reason: reason && sayReason(reason), list: list?.split(", ").map(sayReason).join(", ") });
}

export const numberText = (value) => value.toLocaleString(locale.value, { maximumFractionDigits: 20, useGrouping: false });
