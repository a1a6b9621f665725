// What happened in a room, newest first.
import { useState } from "preact/hooks";
import { call } from "../door.js";
import { Entry } from "../entry.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { useOpen } from "../opened.js";

const LATELY = 6; // entries

export function Lately({ ids, isWide }) {
  const [entries, setEntries] = useState([]);
  useOpen(() => {
    call("/control/journal", { limit: 400 }).then((answer) => setEntries(answer.entries.filter((one) => ["requested", "changed"].includes(one.kind) && ids.includes(one.device)).reverse().slice(0, LATELY)), () => {});
  }, [ids.join()]);
  if (!entries.length) return null;
  return html`<section class=${isWide ? "card lately two" : "card lately"} aria-labelledby="lately"><h2 id="lately">${say("Lately here")}</h2><ol class="log">${entries.map((one, at) => html`<${Entry} key=${at} entry=${one} />`)}</ol></section>`;
}
