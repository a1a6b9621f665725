// The key of an English text in the tables of other languages, where the text itself would be half of what is loaded.
const LETTERS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
const FACTOR = 0; // found by the build, so that each text has a key of its own

/** Three letters. */
export function keyOf(text, factor = FACTOR) {
  let number = 0;
  for (let at = 0; at < text.length; at++) number = (Math.imul(number, factor) + text.charCodeAt(at)) >>> 0;
  return [1, 62, 3844].map((size) => LETTERS[Math.floor(number / size) % 62]).join("");
}
