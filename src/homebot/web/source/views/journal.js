// The journal: what was commanded, by whom, and what it led to; newest first.
import { useEffect, useState } from "preact/hooks";
import { call, connection, subscribe } from "../door.js";
import { nameOf } from "../house.js";
import { html } from "../html.js";
import { entryText, timeText } from "../words.js";

const MOST = 300;
const TELLING = new Set(["requested", "outcome", "reverted", "changed", "published", "denied", "held", "released", "ended", "expired", "outranked"]);

export function Journal() {
  const [entries, setEntries] = useState([]);
  const [isWhole, setIsWhole] = useState(false);
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return undefined;
    let early = [];
    let isLoading = true;
    const end = subscribe("/control/journal_entries", (entry) => {
      if (isLoading) early.push(entry);
      else setEntries((old) => [entry, ...old].slice(0, MOST));
    });
    call("/control/journal", { limit: MOST }).then(
      (answer) => {
        isLoading = false;
        setEntries([...answer.entries, ...early].reverse().slice(0, MOST));
        early = [];
      },
      () => (isLoading = false),
    );
    return end;
  }, [isOpen]);
  const shown = isWhole ? entries : entries.filter((one) => TELLING.has(one.kind) || (one.kind === "judged" && !one.verdicts[0]?.allowed));
  return html`
    <p class="choices"><label><input type="checkbox" checked=${isWhole} onChange=${(event) => setIsWhole(event.target.checked)} /> every step</label></p>
    ${shown.length === 0 && html`<p class="empty">Nothing has happened yet.</p>`}
    <table class="journal">
      <thead><tr><th>Time</th><th>Device</th><th>What happened</th></tr></thead>
      <tbody>
        ${shown.map((one, index) => html`<tr key=${`${one.at.sec}.${one.at.nanosec} ${one.kind} ${one.command} ${shown.length - index}`}>
          <td><time>${timeText(one.at)}</time></td>
          <td>${one.device && html`<a href=${`#/device/${encodeURIComponent(one.device)}`}>${nameOf(one.device)}</a>`}</td>
          <td>${entryText(one)}</td>
        </tr>`)}
      </tbody>
    </table>`;
}
