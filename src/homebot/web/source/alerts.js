// What is wrong in the house, above everything: what cannot wait by itself, the rest as numbers.
import { effect, signal } from "@preact/signals";
import { tell } from "./acting.js";
import { ask, connection, may, subscribe } from "./door.js";
import { deviceOf, nameOf } from "./house.js";
import { html } from "./html.js";
import { language, say } from "./language.js";

const CAN_WAIT = new Set(["HB401", "HB402", "HB404"]); // unreachable and silent devices, weak batteries

const findings = signal([]);
const repeats = signal(false); // whether people are told again and again

subscribe("/alerts/findings", (message) => {
  findings.value = message.findings;
  repeats.value = message.repeats;
});
effect(() => {
  if (connection.value.state === "connecting") findings.value = [];
});

async function see() {
  const { success, message } = await ask("/alerts/seen");
  tell(success ? say("Nobody is told of it again.") : message, success);
}

export function Alerts() {
  const urgent = findings.value.filter((one) => !CAN_WAIT.has(one.code));
  const others = findings.value.filter((one) => CAN_WAIT.has(one.code));
  return html`
    ${urgent.map(
      (one) => html`<section key=${one.code} class="alert" role="alert">
        <h2>${say(one.title || "problem")}</h2>
        ${one.rows.map((row) => html`<p key=${row.what + row.why}>${deviceOf(row.what) && html`<a href=${`#/device/${encodeURIComponent(row.what)}`}>${nameOf(row.what)}</a>`} ${(language.value === "en" || !row.what) && row.why}</p>`)}
        ${one.next && html`<p><strong>${say(one.next)}</strong></p>`}
      </section>`,
    )}
    ${urgent.length > 0 && repeats.value && may("act") && html`<p class="choices"><button type="button" onClick=${see}>${say("I have seen it")}</button></p>`}
    ${others.length > 0 && html`<p class="legend"><a href="#/system">${others.map((one) => `${say(one.title)}: ${one.total}`).join(" · ")}</a></p>`}`;
}
