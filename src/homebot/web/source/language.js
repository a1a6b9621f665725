// The language of the page: the browser's, or the one that was chosen here. A row of the table is an English text in the others.
import { computed, effect, signal } from "@preact/signals";
import { FIELDS, keyOf, keysIn } from "./text_key.js";
export const LANGUAGES = { en: "English", de: "Deutsch", fr: "Français", es: "Español", nl: "Nederlands", it: "Italiano" };

/** Each language is loaded when it is chosen: what the first views say. */
const LOADERS = { de: () => import("./languages/de.js"), es: () => import("./languages/es.js"), fr: () => import("./languages/fr.js"), it: () => import("./languages/it.js"), nl: () => import("./languages/nl.js") };
const LATE = { de: () => import("./languages/de_late.js"), es: () => import("./languages/es_late.js"), fr: () => import("./languages/fr_late.js"), it: () => import("./languages/it_late.js"), nl: () => import("./languages/nl_late.js") };
const ENGLISH = { texts: "" };
export const SOON = 2000; // ms after which the rest is loaded in any case
const CHOICE = "homebot.language";

const first = [localStorage.getItem(CHOICE), ...navigator.languages].map((one) => one?.slice(0, 2)).find((one) => one in LANGUAGES) ?? "en";
const tableOf = async (name) => (await LOADERS[name]?.().catch(() => {})) ?? ENGLISH; // English, where homebot is away

const linesOf = (text) => text.replace(/[#$&*<>^~]/g, (sign) => FIELDS[sign]).split("\n");

/** Texts by their keys, which are the first line. */
function byKey(lines) {
  const [letters, ...texts] = linesOf(lines);
  const keys = keysIn(letters);
  return new Map(texts.map((text, at) => [keys[at], text]));
}

const table = signal(byKey((await tableOf(first)).texts));
let patterns = [];
let rest = null;
/** Load the rest of the language: the texts of later views, and the forms of reasons. */
export const loadRest = () => (rest ??= addRest(language.value).catch(() => (rest = null)));

async function addRest(name) {
  const { texts, reasons } = (await LATE[name]?.()) ?? { ...ENGLISH, reasons: "" };
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
const fill = (text, values) => text.replace(/\{(\w+)\}/g, (all, name) => values[name] ?? all);

/** An English text in the language of the page, with values for its {names}; an ending after | tells equal texts apart. */
export function say(text, values = {}) {
  const own = language.value === "en" ? "" : table.value.get(keyOf(text));
  if (own === undefined) loadRest(); // a first view shows what few do, such as an alert
  return fill(own || text.replace(/\|\w+$/, ""), values);
}

/** The forms of reasons in this language, each with the pattern of its English form: lines of the one follow those of the other. */
function patternsOf(lines) {
  const forms = linesOf(lines);
  const known = forms.splice(0, forms.length / 2);
  return known.map((text, at) => [forms[at], new RegExp(`^${text.replace(/[()[\].?]/g, "\\$&").replace(/\{(\w+)\}/g, "(?<$1>.+?)")}$`)]);
}

/** How fields of a reason are said; others are names and numbers. */
const SPOKEN = { value: (text) => say(text), reason: sayReason, advice: sayReason, list: (text) => text.split(", ").map(sayReason).join(", ") };

/** A reason that homebot gives in English, in the language of the page: as a whole, by its form, or clause by clause. */
export function sayReason(text) {
  if (text.includes("\n")) return text.split("\n").map(sayReason).join("\n");
  const whole = /[^ -~]/.test(text) ? text : say(text); // others are in another language, or have a name
  if (whole !== text) return whole;
  for (const [own, pattern] of patterns) {
    const found = pattern.exec(text);
    if (!found) continue;
    return fill(own, Object.fromEntries(Object.entries(found.groups).map(([name, text]) => [name, SPOKEN[name]?.(text) ?? text])));
  }
  return text.replace(/^(.+?)(; |: )(.+)$/, (all, first, sign, others) => (sign === ": " ? first : sayReason(first)) + sign + sayReason(others)); // a name is no reason
}

export const numberText = (value) => value.toLocaleString(locale.value, { maximumFractionDigits: 20, useGrouping: false });
