// What people do again and again, as routines to accept or to reject, each with its proof.
import { useState } from "preact/hooks";
import { tell } from "../../acts.js";
import { ask, may } from "../../door.js";
import { html } from "../../html.js";
import { language, say, sayReason } from "../../language.js";
import { durationText, seconds, timeIn } from "../../words.js";

const LONGEST = 300; // seconds of a search

/** `Parts` shows a routine. */
export function Habits({ zone, onChange, Parts }) {
  const [found, setFound] = useState(null); // null before it was asked for
  const look = async () => {
    setFound({ proposals: [], isSearching: true });
    setFound({ proposals: [], ...(await ask("/habits/suggest", {}, LONGEST)) });
  };
  const decide = async (id, accept) => {
    const { success, message } = await ask("/habits/decide", { id, accept }, LONGEST);
    tell(sayReason(message), success);
    if (success) setFound((old) => ({ ...old, proposals: old.proposals.filter((one) => one.id !== id) }));
    onChange();
  };
  const { proposals = [], watched = [], isSearching, success, message } = found ?? {};
  return html`
    <h2>${say("Your habits")}</h2>
    <p class="choices"><button type="button" disabled=${isSearching} onClick=${look}>${say(isSearching ? "searching …" : "look for habits")}</button> <small>${say("homebot looks in the history of four weeks for what you do again and again, and watches that for a week before it proposes it.")}</small></p>
    ${message && html`<p class="bad">${sayReason(message)}</p>`}
    ${success && !proposals.length && html`<p class="empty">${say("There is nothing to propose.")}</p>`}
    ${watched.map((name) => html`<p class="quiet" key=${name}>${say("watching: {name}", { name })}</p>`)}
    <div class="columns">${proposals.map((one) => html`<${Proposal} key=${one.id} proposal=${one} zone=${zone} decide=${decide} Parts=${Parts} />`)}</div>`;
}

function Proposal({ proposal, zone, decide, Parts }) {
  const { id, removes, name, when, conditions, occasions, proof } = proposal;
  const proved = language.value === "en" || removes ? proof : say("In the week of the trial you did this {done} of {total} times; a routine would be right {low} to {high} % of the time.", { done: proposal.trial_done, total: proposal.trial_total, low: Math.round(100 * proposal.precision_low), high: Math.round(100 * proposal.precision_high) });
  return html`<section>
    <h3>${removes ? say("remove {name}", { name: removes }) : html`<bdi>${name}</bdi>`}</h3>
    ${!removes && html`<${Parts} of=${{ when: [when], conditions, steps: [proposal.do] }} />`}
    <p>${proved}</p>
    ${occasions.length > 0 && html`<details><summary>${say("each time")}</summary>
      <ol class="log">${[...occasions].reverse().map((one) => html`<li class="own" key=${seconds(one.at)}><time>${timeIn(zone, one.at)}</time><span class=${seconds(one.done_at) ? "" : "bad"}>${occasionText(one)}</span></li>`)}</ol>
    </details>`}
    ${may("manage") && html`<p class="choices"><button type="button" onClick=${() => decide(id, true)}>${say(removes ? "remove" : "accept")}</button> <button type="button" onClick=${() => decide(id, false)}>${say(removes ? "keep" : "reject")}</button></p>`}
  </section>`;
}

function occasionText({ at, done_at: done }) {
  if (!seconds(done)) return say("you did not");
  const late = seconds(done) - seconds(at);
  return say(late < 0 ? "you did it {time} before" : "you did it {time} later", { time: durationText(Math.abs(late)) });
}
