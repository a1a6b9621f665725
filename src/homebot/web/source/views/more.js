// On a phone: the views that have no place in its bar.
import { LAST } from "../frame.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { say } from "../language.js";
import { Screen } from "./screen.js";

export const More = () => html`<h1>${say("More")}</h1>
  <nav class="list" aria-label=${say("More")}>${Object.entries(LAST).map(([view, text]) => html`<a key=${view} href=${`#/${view}`}><${Sign} path=${SIGNS[view]} size=${26} /> <span>${say(text)}</span> <${Sign} path=${SIGNS.right} /></a>`)}</nav>
  <${Screen} />`;
