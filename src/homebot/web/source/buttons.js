// The button of an act, which is held where the act is guarded; and a slider of per cent.
import { useState } from "preact/hooks";
import { codeOf, isGuarded, perform, setting } from "./acts.js";
import { read } from "./house.js";
import { html } from "./html.js";
import { Sign } from "./icons.js";
import { Keypad } from "./keypad.js";
import { say } from "./language.js";
import { HoldButton } from "./touch.js";
import { capital, label, textOf, valueText } from "./words.js";

export function ActButton({ device, act, sign, name = "" }) {
  const [asks, setAsks] = useState(false);
  const text = say(`${act.text}|do`);
  const kind = codeOf(device, act);
  const done = (code) => {
    setAsks(false);
    perform(device, act, { isHeld: true, code });
  };
  if (asks) return html`<${Keypad} text=${text} kind=${kind} isHeld=${isGuarded(device, act)} onDone=${done} onCancel=${() => setAsks(false)} />`;
  if (kind) return html`<button type="button" class=${name} onClick=${() => setAsks(true)}>${capital(text)} …</button>`;
  if (isGuarded(device, act)) return html`<${HoldButton} text=${text} name=${name} onHeld=${() => perform(device, act, { isHeld: true })} />`;
  return html`<button type="button" class=${name} aria-label=${`${device.name}: ${text}`} onClick=${() => perform(device, act)}>${sign ? html`<${Sign} path=${sign} size=${28} />` : capital(text)}</button>`;
}

/** A button for each option of a capability. */
export function Choice({ device, capability, options }) {
  const now = read(device, capability);
  return html`<div class="modes" role="group" aria-label=${label(capability)}>${options.map((one) => html`<button key=${one} type="button" aria-pressed=${String(one === now)} onClick=${() => one !== now && perform(device, setting("", capability, one))}>${capital(textOf(capability, one))}</button>`)}</div>`;
}

/** A number of per cent with a slider. */
export function Amount({ device, capability, text = label(capability) }) {
  const value = Math.round(read(device, capability) ?? 0);
  return html`<label class="amount"><span>${text}</span><input type="range" min="0" max="100" value=${value} onChange=${(event) => perform(device, setting("", capability, event.target.valueAsNumber))} /><output>${valueText(capability, value, "%")}</output></label>`;
}
