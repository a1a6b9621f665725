// What is wrong in the house, above everything: what cannot wait by itself, the rest as numbers.
import { effect, signal } from "@preact/signals";
import { connection, subscribe } from "./door.js";
import { deviceOf, nameOf } from "./house.js";
import { html } from "./html.js";
import { language, say } from "./language.js";

const CAN_WAIT = new Set(["HB401", "HB402", "HB404"]); // unreachable and silent devices, weak batteries

const findings = signal([]);

subscribe("/alerts/findings", (message) => (findings.value = message.findings));
effect(() => {
  if (connection.value.state === "connecting") findings.value = [];
});

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
    ${others.length > 0 && html`<p class="legend"><a href="#/system">${others.map((one) => `${say(one.title)}: ${one.total}`).join(" · ")}</a></p>`}`;
}
