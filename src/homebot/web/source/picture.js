// The newest picture of a camera, asked for again while it is looked at.
import { html } from "./html.js";
import { say } from "./language.js";

export const Picture = () => html`<p class="empty">${say("This camera has sent no picture.")}</p>`;
