import htm from "htm";
import { h } from "preact";

export const html = htm.bind(h);

/** What a person has written in a form that is submitted, which the browser is not to send by itself. */
export function written(event) {
  event.preventDefault();
  return new FormData(event.target);
}
