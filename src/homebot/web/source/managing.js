// What a page may not do without a right, and who gives it.
import { useState } from "preact/hooks";
import { may } from "./door.js";
import { html } from "./html.js";
import { say } from "./language.js";

/** The right that the page lacks, once its rights are known. */
export const Lacking = ({ right, lacks = !may(right) }) => lacks && may("read") && html`<p class="quiet">${say("This screen lacks the right {right}. The owner gives it a token with more rights: System, Set up, Screens.", { right })}</p>`;

/** What it holds, if the page may manage homebot. */
export const Managing = ({ children }) => (may("manage") ? children : html`<${Lacking} right="manage" />`);

/** A button that asks before it removes. */
export function Remove({ name, onRemove }) {
  const [asks, setAsks] = useState(false);
  return html`<button type="button" class=${asks ? "bad" : ""} onClick=${asks ? onRemove : () => setAsks(true)}>${asks ? say("remove {name} for good", { name }) : say("remove")}</button>`;
}
