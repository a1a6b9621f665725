// What happened in a room, newest first.
import { useEffect, useState } from "preact/hooks";
import { call, connection } from "../door.js";
import { Entry } from "../entry.js";
import { html } from "../html.js";
import { say } from "../language.js";

const LATELY = 6; // entries

export function Lately({ ids, isWide }) {
  const [entries, setEntries] = useState([]);
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return;
    call("/control/journal", { limit: 400 }).then((answer) => setEntries(answer.entries.filter((one) => ["requested", "changed"].includes(one.kind) && ids.includes(one.device)).reverse().slice(0, LATELY)), () => {});
  }, [isOpen, ids.join()]);
  if (!entries.length) return null;
  return html`<section class=${isWide ? "card lately two" : "card lately"} aria-labelledby="lately"><h2 id="lately">${say("Lately here")}</h2><ol class="log">${entries.map((one, at) => html`<${Entry} key=${at} entry=${one} />`)}</ol></section>`;
}
