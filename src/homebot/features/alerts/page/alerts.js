// What is wrong in the house, above everything: what cannot wait by itself, the rest as numbers.
import { effect, signal } from "@preact/signals";
import { tell } from "../../acts.js";
import { ask, connection, may, subscribe } from "../../door.js";
import { deviceOf, nameOf } from "../../house.js";
import { html } from "../../html.js";
import { SIGNS, Sign } from "../../icons.js";
import { say, sayReason } from "../../language.js";
import { openSheet } from "../../tile.js";

const findings = signal([]);
const repeats = signal(false); // whether people are told again and again

subscribe("/alerts/findings", (message) => {
  findings.value = message.findings;
  repeats.value = message.repeats;
});
effect(() => {
  if (connection.value.state === "connecting") findings.value = [];
});

export const urgent = () => findings.value.filter((one) => one.urgency !== "later");

async function see() {
  const { success, message } = await ask("/alerts/seen");
  tell(success ? say("Nobody is told of it again.") : sayReason(message), success);
}

export function Alerts() {
  const others = findings.value.filter((one) => one.urgency === "later");
  const found = urgent();
  return html`
    ${found.map(
      (one, at) => html`<section key=${one.code} class="banner alarm" role="alert"><${Sign} path=${SIGNS.alert} size=${48} />
        <div>
          <h2>${say(one.title || "problem")}</h2>
          ${one.rows.map((row) => html`<p key=${row.what + row.why}>${deviceOf(row.what) && html`<button type="button" class="link" onClick=${() => openSheet(row.what)}>${nameOf(row.what)}</button>`} ${sayReason(row.why)}</p>`)}
          ${one.next && html`<p><strong>${say(one.next)}</strong></p>`}
        </div>
        ${at === found.length - 1 && repeats.value && may("act") && html`<button type="button" class="seen" onClick=${see}><${Sign} path=${SIGNS.check} /> ${say("I have seen it")}</button>`}
      </section>`,
    )}
    ${others.length > 0 && html`<p class="notes"><a href="#/system">${others.map((one) => `${say(one.title)}: ${one.total}`).join(" · ")}</a></p>`}`;
}
