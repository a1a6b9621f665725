// What only a page may do that has the right to manage homebot.
import { useState } from "preact/hooks";
import { may } from "./door.js";
import { html } from "./html.js";
import { say } from "./language.js";

/** What it holds; else what the page lacks. */
export const Managing = ({ children }) => (may("manage") ? children : html`<p class="quiet">${say("To change this, log in with a token that has the right manage.")}</p>`);

/** A button that asks before it removes. */
export function Remove({ name, onRemove }) {
  const [asks, setAsks] = useState(false);
  return html`<button type="button" class=${asks ? "bad" : ""} onClick=${asks ? onRemove : () => setAsks(true)}>${asks ? say("remove {name} for good", { name }) : say("remove")}</button>`;
}
