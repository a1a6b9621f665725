// A backup of the home, as `homebot backup` makes it, for a download.
import { useState } from "preact/hooks";
import { call } from "../door.js";
import { html } from "../html.js";
import { say, sayReason } from "../language.js";

const WITHIN = 120; // seconds for a part

/** Return the backup in parts, and call `onPart` with the fraction that is there. */
async function fetchBackup(onPart) {
  const parts = [];
  let offset = 0;
  for (;;) {
    const { success, message, data, ...facts } = await call("/setup/backup", { offset }, WITHIN);
    if (!success) throw new Error(message);
    parts.push(Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)));
    offset += parts.at(-1).length;
    onPart(offset / facts.size);
    if (offset >= facts.size) return { ...facts, blob: new Blob(parts, { type: "application/x-tar" }) };
  }
}

export function Backup() {
  const [state, setState] = useState({});
  const make = async () => {
    setState({ part: 0 });
    try {
      const { name, blob, left_out: leftOut } = await fetchBackup((part) => setState({ part }));
      const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 60_000); // the browser saves it by then
      setState({ name, size: blob.size, leftOut });
    } catch (error) {
      setState({ problem: error.message });
    }
  };
  const { part, name, size, leftOut = [], problem } = state;
  return html`<p>${say("It has all that homebot keeps, but no passwords.")}</p>
    <p class="buttons"><button type="button" class="chief" name="backup" disabled=${part !== undefined} onClick=${make}>${say("make a backup")}</button></p>
    <div role="status" class=${part === undefined && !name && !problem ? "hidden" : "box"}>
      ${part !== undefined && html`<p>${say("It is being made …")} ${part > 0 && `${Math.round(100 * part)} %`}</p>`}
      ${name && html`<p>${say("{name} was downloaded ({size} kB).", { name, size: Math.ceil(size / 1000).toLocaleString() })}</p><p class="quiet">${say("To put it back:")} <code>homebot restore ${name}</code></p>`}
      ${leftOut.length > 0 && html`<p class="quiet">${say("Left out, as they hold secrets: {files}", { files: leftOut.join(", ") })}</p>`}
      ${problem && html`<p class="bad">${sayReason(problem)}</p>`}
    </div>`;
}
