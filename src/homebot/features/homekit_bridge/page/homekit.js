// The bridges of the house in Apple Home: the code that pairs each, and what is not there.
import { useState } from "preact/hooks";
import { ask, call, may } from "../../door.js";
import { html } from "../../html.js";
import { say, sayReason } from "../../language.js";
import { Remove } from "../../managing.js";
import { useOpen } from "../../opened.js";

const AGAIN = 5000; // ms
const EDGE = 4; // modules that are to be light around a QR code: ISO/IEC 18004, 6.3.8

/** Nothing in a house without the table `homekit_bridge`, whose service nobody offers. */
export function Homekit() {
  const [found, setFound] = useState(null);
  const look = () => call("/homekit_bridge/pairing").then(setFound, () => {});
  useOpen(() => may("manage") && look().then(() => AGAIN), [may("manage")]);
  if (!found) return null;
  return html`<section>
    <h2>Apple Home</h2>
    ${found.message && html`<p class="bad">${sayReason(found.message)}</p>`}
    ${found.bridges.map((bridge) => html`<div key=${bridge.id} class="box"><h3>${bridge.name}</h3>
      ${bridge.code ? html`<p>${say("In the app Home: +, Add Accessory, and scan this, or type the code.")}</p><${Code} rows=${bridge.qr} /><p><b>${bridge.code}</b></p>` : html`<p>${say("Paired with {count} controllers.", { count: bridge.controllers })}</p>`}
      <p class="quiet">${bridge.accessories.join(", ")}</p></div>`)}
    ${found.left_out.length > 0 && html`<table class="facts"><tbody>${found.left_out.map(({ key, value }) => html`<tr key=${key}><th scope="row">${key}</th><td>${sayReason(value)}</td></tr>`)}</tbody></table>`}
    ${found.bridges.some((bridge) => !bridge.code) && html`<p class="choices"><${Remove} name=${say("the pairings with Apple Home")} onRemove=${() => ask("/homekit_bridge/unpair", {}).then(look)} /></p>`}
  </section>`;
}

function Code({ rows }) {
  const side = rows.length + 2 * EDGE;
  const dark = rows.flatMap((row, y) => [...row].flatMap((cell, x) => (cell === "1" ? `M${x + EDGE} ${y + EDGE}h1v1h-1z` : []))).join("");
  return rows.length > 0 && html`<svg role="img" aria-label=${say("QR code")} width="200" viewBox=${`0 0 ${side} ${side}`} shape-rendering="crispEdges"><path fill="#fff" d=${`M0 0h${side}v${side}h-${side}z`} /><path fill="#000" d=${dark} /></svg>`;
}
