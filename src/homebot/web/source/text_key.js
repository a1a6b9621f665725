// The key of an English text in the tables of other languages, where the text itself would be half of what is loaded.
const FACTOR = 0; // found by the build, so that each text has a key of its own

/** A number below 2 ** 21: what homebot says and no table has is taken for another text once in 2,500. */
export function keyOf(text, factor = FACTOR) {
  let number = 0;
  for (let at = 0; at < text.length; at++) number = (Math.imul(number, factor) + text.charCodeAt(at)) >>> 0;
  return number >>> 11;
}

/** Keys in their order, by their distances, which pack better. */
export const written = (keys) => keys.map((key, at) => (key - (keys[at - 1] ?? 0)).toString(36)).join(" ");

export function keysIn(line) {
  let key = 0;
  return line.split(" ").map((gap) => (key += parseInt(gap, 36)));
}

/** The most frequent fields of texts, by signs that no text has: they pack better than names. */
export const FIELDS = { "#": "{name}", $: "{what}", "&": "{reason}", "*": "{count}", "<": "{value}", ">": "{time}", "^": "{id}", "~": "{room}" };
