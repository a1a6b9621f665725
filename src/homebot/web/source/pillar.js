// A level as a large area that a finger fills, with its button and presets beside it.
import { useState } from "preact/hooks";
import { isGuarded, perform, pending } from "./acts.js";
import { ActButton } from "./buttons.js";
import { takes } from "./house.js";
import { html } from "./html.js";
import { SIGNS, Sign } from "./icons.js";
import { kindOf, stateOf, toneOf } from "./kinds.js";
import { say } from "./language.js";
import { capital } from "./words.js";

const PRESETS = [100, 50, 10];

/** The level of a device that may have one, with on and off. */
export function Pillar({ device, level, isOn }) {
  const [moved, setMoved] = useState(null);
  const kind = kindOf(device);
  const own = kind.act(device);
  const power = own && (isGuarded(device, own)
    ? html`<${ActButton} device=${device} act=${own} />`
    : html`<button type="button" class="chief" role="switch" aria-checked=${String(isOn)} aria-label=${device.name} onClick=${() => perform(device, own)}><${Sign} path=${SIGNS.power} size=${26} /> ${capital(say(isOn ? "on" : "off"))}</button>`);
  if (level === null) return own && html`<div class=${`solo ${toneOf(device)}`}>${power}</div>`;
  const set = (value) => perform(device, kind.slide(value));
  const value = moved ?? level;
  return html`<div class=${`dimmer ${toneOf(device)}`}>
    <label class="pillar">
      <span class="fill" style=${{ blockSize: `${value}%` }}></span>
      <output>${moved === null ? (pending.value.has(device.id) ? "…" : stateOf(device)) : `${moved}\u00a0%`}</output>
      <input type="range" min="0" max="100" value=${value} aria-label=${say("level")} aria-orientation="vertical" aria-valuetext=${stateOf(device)} onInput=${(event) => setMoved(event.target.valueAsNumber)} onChange=${(event) => { setMoved(null); set(event.target.valueAsNumber); }} />
    </label>
    <div class="column">
      ${takes(device, "on_off") && power}
      ${PRESETS.map((one) => html`<button key=${one} type="button" aria-pressed=${String(isOn && level === one)} onClick=${() => set(one)}>${one}\u00a0%</button>`)}
    </div>
  </div>`;
}
