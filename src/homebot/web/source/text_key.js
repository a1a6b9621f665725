// The key of an English text in the tables of other languages, where the text itself would be half of what is loaded.
const LETTERS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

/** Four letters; the build fails if two texts have the same. */
export function keyOf(text) {
  let number = 0;
  for (let at = 0; at < text.length; at++) number = (Math.imul(number, 29) + text.charCodeAt(at)) >>> 0;
  return [1, 62, 3844, 238328].map((size) => LETTERS[Math.floor(number / size) % 62]).join("");
}
