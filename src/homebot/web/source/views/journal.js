// The journal: what was commanded, by whom, and what it led to; newest first.
import { useEffect, useState } from "preact/hooks";
import { call, connection, subscribeFrames } from "../door.js";
import { Entry, entryText } from "../entry.js";
import { nameOf } from "../house.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { hasWords } from "../words.js";

const KEPT = 1000; // entries that can be searched, as many as homebot answers with
const MOST = 300; // that are shown
const TELLING = new Set(["requested", "outcome", "reverted", "changed", "published", "denied", "held", "released", "ended", "expired", "outranked"]);

export function Journal() {
  const [entries, setEntries] = useState([]);
  const [isLoaded, setIsLoaded] = useState(false);
  const [isWhole, setIsWhole] = useState(false);
  const [sought, setSought] = useState("");
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return undefined;
    let early = [];
    let isLoading = true;
    const end = subscribeFrames("/control/journal_entries", (found) => {
      const came = numbered(found);
      if (isLoading) early.unshift(...came);
      else setEntries((old) => [...came, ...old].slice(0, KEPT));
    });
    call("/control/journal", { limit: KEPT }).then(
      (answer) => {
        isLoading = false;
        setEntries([...early, ...numbered(answer.entries)].slice(0, KEPT));
        early = [];
        setIsLoaded(true);
      },
      () => (isLoading = false),
    );
    return end;
  }, [isOpen]);
  const asked = new Set(entries.filter((one) => one.kind === "requested").map((one) => one.command));
  const outcomes = new Map(entries.filter((one) => one.kind === "outcome").map((one) => [one.command, one]));
  const told = isWhole ? entries : entries.filter((one) => TELLING.has(one.kind) && !(one.kind === "outcome" && asked.has(one.command)));
  const outcomeOf = (one) => (!isWhole && one.kind === "requested" ? outcomes.get(one.command) : undefined);
  const textOf = (one) => [nameOf(one.device), one.device, entryText(one), ...[outcomeOf(one)].filter(Boolean).map(entryText)].join(" ");
  const shown = (sought.trim() ? told.filter((one) => hasWords(textOf(one), sought)) : told).slice(0, MOST);
  return html`<section>
    <p class="choices">
      <label>${say("Search")} <input type="search" value=${sought} onInput=${(event) => setSought(event.target.value)} /></label>
      <label><input type="checkbox" checked=${isWhole} onChange=${(event) => setIsWhole(event.target.checked)} /> ${say("every step")}</label>
    </p>
    ${isLoaded && shown.length === 0 && html`<p class="empty">${told.length ? say("None of the newest {count} entries has these words.", { count: entries.length }) : say("Nothing has happened yet.")}</p>`}
    <ol class="log" aria-label=${say("newest first")}>
      ${shown.map((one) => html`<${Entry} key=${one.number} entry=${one} outcome=${outcomeOf(one)} />`)}
    </ol>
  </section>`;
}

let number = 0; // of the last entry that came

/** The entries, newest first, each with a number of its own as its key. */
const numbered = (entries) => entries.map((one) => ({ ...one, number: ++number })).reverse();
