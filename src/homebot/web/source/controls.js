// The controls of a device, one for each value that it takes: words, a slider, a colour, steps, a choice or a field.
import { useEffect, useRef, useState } from "preact/hooks";
import { codeOf, command } from "./acts.js";
import { html, written } from "./html.js";
import { say } from "./language.js";
import { Stepper } from "./stepper.js";
import { HoldButton } from "./touch.js";
import { UNNAMED, label, roundedTo, textOf, unitOf, valueText, vocabulary } from "./words.js";

const WORDS = {
  on_off: ["on", "off"],
  movement: ["open", "stop", "close"],
  lock: ["lock", "unlock"],
  valve: ["open", "close"],
  push: ["press"],
  scene: ["press"],
  locate: ["press"],
};

/** Words that may let in, flood or burn, where the capability asks first. */
const OPENING = new Set(["open", "unlock", "press", "on"]);

const QUIET = 300; // ms after the last move of a slider, by keys too

/** All that a device takes, by its short and its full form, `without` some capabilities. */
export function Controls({ short, device, without = [] }) {
  const found = device.parts
    .filter(({ part }) => !part.category)
    .flatMap(({ id, part }) => part.capabilities.filter((one) => one.settable && !without.includes(one.name)).map((capability) => ({ id, part, capability })));
  if (!found.length) return null;
  return html`<div class="commands">
    ${found.map(({ id, part, capability }) => {
      const isTwice = found.filter((one) => one.capability.name === capability.name).length > 1;
      const name = (UNNAMED.has(capability.name) && (part.name || (!isTwice && short.name))) || `${isTwice && id ? `${part.name || id} ` : ""}${label(capability.name)}`;
      const reading = short.states.get(`${id} ${capability.name}`);
      const target = { id: id ? `${device.id}#${id}` : device.id, name: short.name };
      return html`<${Control} key=${`${id} ${capability.name}`} short=${short} reading=${reading} target=${target} name=${name} capability=${capability} />`;
    })}
  </div>`;
}

function Control({ short, reading, target, name, capability }) {
  const now = reading?.value;
  const unit = unitOf(capability);
  const [least, most] = capability.bounds.length || unit !== "%" ? capability.bounds : [0, 100];
  const send = (value, code = "") => command(target, "set", [{ key: capability.name, value }], code);
  if (WORDS[capability.name]) return html`<${Words} short=${short} target=${target} name=${name} capability=${capability.name} />`;
  if (capability.name === "color") return html`<label><span>${name}</span> <input type="color" value=${hexOf(now)} onChange=${(event) => send(hueOf(event.target.value))} /></label>`;
  if (!capability.options.length && most !== undefined && (unit === "%" || unit === "K"))
    return html`<${Slider} name=${name} now=${now} unit=${unit} least=${least} most=${most} capability=${capability} send=${send} />`;
  if (capability.name.endsWith("_setpoint") && typeof now === "number")
    return html`<div><span>${name}</span> <${Stepper} device=${short} reading=${reading} /></div>`;
  return html`<${Field} short=${short} name=${name} now=${now} unit=${unit} least=${least} most=${most} capability=${capability} send=${send} />`;
}

function Words({ short, target, name, capability }) {
  const [code, setCode] = useState("");
  const send = (word, isHeld) => {
    command(target, word, [], code, isHeld);
    setCode("");
  };
  return html`<div role="group" aria-label=${name}>
    <span>${name}</span>
    ${WORDS[capability].map((word) => {
      const text = say(`${word}|do`);
      return OPENING.has(word) && short.asks_first.includes(capability) ? html`<${HoldButton} key=${word} text=${text} onHeld=${() => send(word, true)} />` : html`<button key=${word} type="button" onClick=${() => send(word, false)}>${text}</button>`;
    })}
    ${codeOf(short, { capability }) && html`<${Code} value=${code} onInput=${setCode} />`}
  </div>`;
}

/** A slider, which follows the finger, and then the device. */
function Slider({ name, now, unit, least, most, capability, send }) {
  const [moved, setMoved] = useState(null);
  const timer = useRef(0);
  useEffect(() => () => clearTimeout(timer.current), []);
  const value = moved ?? (typeof now === "number" ? roundedTo(now, unit, capability.grid[1]) : least);
  const change = (event) => {
    const wanted = event.target.valueAsNumber;
    clearTimeout(timer.current);
    timer.current = setTimeout(async () => {
      await send(String(wanted));
      setMoved((old) => (old === wanted ? null : old));
    }, QUIET);
  };
  return html`<label>
    <span>${name}</span>
    <input type="range" name="value" min=${least} max=${most} step=${unit === "K" ? capability.grid[1] || 50 : capability.grid[1] || 1} value=${value} onInput=${(event) => setMoved(event.target.valueAsNumber)} onChange=${change} />
    <output>${now === null && moved === null ? "" : valueText(capability.name, value, unit)}</output>
  </label>`;
}

/** A choice, a number or a text, with a button. */
function Field({ short, name, now, unit, least, most, capability, send }) {
  const [code, setCode] = useState("");
  const submit = (event) => {
    send(written(event).get("value"), code);
    setCode("");
  };
  const settable = capability.options.filter((one) => !vocabulary.value.passing[capability.name]?.includes(one));
  const field = capability.options.length
    ? html`<select name="value">
        ${settable.map((one) => html`<option key=${one} value=${one} selected=${one === now}>${textOf(capability.name, one)}</option>`)}
      </select>`
    : typeof now === "number" || most !== undefined
      ? html`<input name="value" type="number" required step="any" min=${least} max=${most} defaultValue=${typeof now === "number" ? roundedTo(now, unit, capability.grid[1]) : ""} />`
      : html`<input name="value" required defaultValue=${now ?? ""} />`;
  return html`<form onSubmit=${submit}>
    <label><span>${name}</span> ${field}</label>
    ${codeOf(short, { capability: capability.name }) && html`<${Code} value=${code} onInput=${setCode} />`}
    <button>${say("set|do")}</button>
    <small>${most === undefined ? unit : say("{least} to {most}", { least, most: `${most} ${unit}` })}</small>
  </form>`;
}

const Code = ({ value, onInput }) => html`<label>${say("code")} <input name="code" type="password" inputmode="numeric" autocomplete="one-time-code" maxlength="255" value=${value} onInput=${(event) => onInput(event.target.value)} /></label>`;

/** Hue and saturation as a colour of the browser, and back. */
function hexOf(now) {
  const [hue, saturation] = Array.isArray(now) ? now : [0, 0];
  const part = (n) => {
    const k = (n + hue / 60) % 6;
    return Math.round(255 * (1 - (saturation / 100) * Math.max(0, Math.min(k, 4 - k, 1))));
  };
  return `#${[part(5), part(3), part(1)].map((one) => one.toString(16).padStart(2, "0")).join("")}`;
}

function hueOf(hex) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const most = Math.max(r, g, b);
  const range = most - Math.min(r, g, b);
  if (!range) return "0,0";
  const sixth = most === r ? (g - b) / range : most === g ? 2 + (b - r) / range : 4 + (r - g) / range;
  return `${Math.round((60 * sixth + 360) % 360)},${Math.round((100 * range) / most)}`;
}
