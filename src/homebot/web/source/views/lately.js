// What happened to some devices, newest first.
import { useState } from "preact/hooks";
import { call } from "../door.js";
import { Entry } from "../entry.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { useOpen } from "../opened.js";

/** The `most` newest entries about devices, of those `among` the newest of the house. */
export function Lately({ ids, title = say("Lately here"), among = 400, most = 6, isWide }) {
  const [entries, setEntries] = useState([]);
  useOpen(() => {
    call("/control/journal", { limit: among }).then((answer) => setEntries(answer.entries.filter((one) => ["requested", "changed"].includes(one.kind) && ids.includes(one.device)).reverse().slice(0, most)), () => {});
  }, [ids.join()]);
  if (!entries.length) return null;
  return html`<section class=${isWide ? "card lately two" : "card lately"} aria-labelledby="lately"><h2 id="lately">${title}</h2><ol class="log">${entries.map((one, at) => html`<${Entry} key=${at} entry=${one} />`)}</ol></section>`;
}
