// An entry of the journal.
import { nameOf } from "./house.js";
import { html } from "./html.js";
import { entryText, spoken, timeText, vocabulary } from "./words.js";

/** One entry, with the `outcome` of its command; without the device if that is `own`. */
export function Entry({ entry, outcome, own = "", names }) {
  const { device } = entry;
  return html`<li class=${own ? "own" : ""}>
    <time>${timeText(entry.at)}</time>
    ${!own && html`<span>${device && html`<a href=${`#/device/${encodeURIComponent(device)}`}>${nameOf(device)}</a>`}</span>`}
    <span class=${isBad(entry) ? "bad" : ""}>
      ${own && device && device !== own && `${spoken(names.get(device) ?? nameOf(device))}: `}${entryText(entry)}${outcome && html`: <span class=${isBad(outcome) ? "bad" : "quiet"}>${entryText(outcome)}</span>`}
    </span>
  </li>`;
}

const isBad = (entry) => vocabulary.value.failures.includes(entry.results[0]?.outcome) || entry.kind === "denied" || (entry.kind === "judged" && !entry.verdicts[0]?.allowed);
