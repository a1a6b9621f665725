// Why a device is as it is, in the words of homebot's journal.
import { useEffect, useState } from "preact/hooks";
import { call, subscribe } from "./door.js";
import { html } from "./html.js";
import { say, sayReason } from "./language.js";
import { Entry } from "./entry.js";
import { useOpen } from "./opened.js";
import { timeText } from "./words.js";

const FINDINGS = {
  event: "Its last event, which is no state:",
  none: "It has reported no change yet.",
  heard: "It is so since homebot first heard of it.",
  retained: "A kept message says so, and not since when.",
  first: "It was so at its first report.",
};
const DELAY = 200; // ms for which changes are gathered

/** What a short answer shows. */
const SHORT = new Set(["requested", "outcome", "changed", "reverted", "denied"]);

/** The causes of the state of a device; `isShort` as in a sheet. */
export function Why({ device, isShort }) {
  const [why, setWhy] = useState(null);
  const [asked, setAsked] = useState(0); // grows when homebot is to be asked again
  const { id, changedAt } = device;
  useOpen(async (isCurrent) => {
    const answer = await call("/control/why", { device: id }).catch(() => null);
    if (isCurrent()) setWhy(answer);
  }, [id, changedAt, asked], DELAY);
  useEffect(() => subscribe("/control/events", (event) => event.device === id && setAsked((old) => old + 1)), [id]);
  if (!why) return html`<section class="why"><h3>${say("Why")}</h3></section>`;
  const names = new Map(why.names.map((one) => [one.key, one.value]));
  const entries = why.entries.filter((one) => (isShort && why.finding !== "event" ? SHORT.has(one.kind) : one.kind !== "judged" || !one.verdicts[0]?.allowed));
  return html`<section class="why">
    <h3>${say("Why")}</h3>
    <p>${why.success ? say(FINDINGS[why.finding] ?? "It changed at {time}.", { time: timeText(why.changed_at) }) : sayReason(why.message)}</p>
    ${entries.length > 0 && html`<ol class="log">${(isShort ? entries.slice(-2) : entries).map((one, index) => html`<${Entry} key=${index} entry=${one} own=${id} names=${names} />`)}</ol>`}
  </section>`;
}
