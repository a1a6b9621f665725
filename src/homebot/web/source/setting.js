// A step of the setup: it writes the file of the configuration, shows its lines, and can be taken back.
import { signal } from "@preact/signals";
import { useState } from "preact/hooks";
import { ask, call } from "./door.js";
import { html } from "./html.js";
import { say, sayReason } from "./language.js";
import { useOpen } from "./opened.js";

const WITHIN = 60; // seconds for a reload of homebot

/** What the last step did. */
export const told = signal(null);

/** A text as TOML writes it: as JSON does. */
export const textOf = (value) => JSON.stringify(value);
const pairs = (values) => Object.entries(values).map(([key, value]) => ({ key, value }));

/** Write `values` into a table, and `secrets` into files, and take the keys `remove` out; return whether that was done. */
export async function change(table, values, { secrets = {}, remove = [] } = {}) {
  told.value = { message: say("writing …"), lines: [], success: true, isPending: true };
  told.value = await ask("/setup/change", { table, values: pairs(values), secrets: pairs(secrets), remove }, WITHIN);
  return told.value.success;
}

const undo = async () => (told.value = { ...(await ask("/setup/change", { undo: true }, WITHIN)), isUndone: true });

/** Begin again, as a change of gateways or people needs. */
export const restart = async () => (told.value = { ...(await ask("/setup/change", { restart: true })), lines: [], isUndone: false, isPending: true });

export const Restart = () => html`<button type="button" name="again" onClick=${restart}>${say("start homebot again")}</button>`;

/** A table of the file, read again after each step; null until then. */
export function useTable(name) {
  const [table, setTable] = useState(null);
  useOpen(() => {
    if (told.value?.isPending) return;
    call("/setup/table", { table: [name] }).then(({ values }) => setTable(Object.fromEntries(values.map(({ key, value }) => [key, JSON.parse(value)]))), () => {});
  }, [told.value]);
  return table;
}

export function Told({ canRestart = false }) {
  const { message, lines = [], success, isPending, isUndone } = told.value ?? {};
  const isDone = success && !isPending;
  return html`<div role="status" class=${message || lines.length || isUndone ? "box" : "hidden"}>
    ${isDone && (isUndone || lines.length > 0) && html`<p>${say(isUndone ? "undone" : "This is in homebot.toml now:")}</p>`}
    ${lines.length > 0 && html`<pre>${lines.join("\n")}</pre>`}
    ${message && html`<p class=${success ? "quiet" : "bad"}>${sayReason(message)}</p>`}
    ${isDone && html`<p class="choices">${!isUndone && html`<button type="button" onClick=${undo}>${say("undo|setup")}</button>`} ${canRestart && message?.includes("restart homebot") && html`<${Restart} />`}</p>`}
  </div>`;
}
