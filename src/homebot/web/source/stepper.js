// A number between a button for less and one for more; the last one of several presses is sent.
import { useEffect, useRef, useState } from "preact/hooks";
import { command } from "./acts.js";
import { call } from "./door.js";
import { read } from "./house.js";
import { html } from "./html.js";
import { SIGNS, Sign } from "./icons.js";
import { say } from "./language.js";
import { label, unitOf, valueText } from "./words.js";

const QUIET = 700; // ms after the last press
/** Of a device that does not say its own: degrees of a thermostat, and per cent. */
const USUAL = { step: 0.5, least: 5, most: 35 };
const PERCENT = { step: 1, least: 0, most: 100 };

const steps = new Map(); // by target and capability, asked for at the first press

async function stepsOf(id, part, capability) {
  const key = `${id} ${part} ${capability}`;
  if (!steps.has(key)) {
    const { devices } = await call("/discovery/find_devices", { ids: [id] });
    const found = devices[0]?.parts.find((one) => one.id === part)?.part.capabilities.find((one) => one.name === capability);
    const usual = capability === "humidity_setpoint" ? PERCENT : USUAL;
    const [least = usual.least, most = usual.most] = found?.bounds ?? [];
    steps.set(key, { least, most, step: found?.grid[1] || usual.step });
  }
  return steps.get(key);
}

const SETPOINTS = ["heating_setpoint", "cooling_setpoint", "humidity_setpoint"];

/** The reading that has a button for less and one for more: of several setpoints, that of the present mode. */
export function stepped(device) {
  const found = [...device.states.values()].filter((one) => SETPOINTS.includes(one.capability) && typeof one.value === "number" && device.settable.includes(one.capability));
  return (read(device, "thermostat_mode") === "cool" && found.find((one) => one.capability === "cooling_setpoint")) || found[0];
}

/** The steps of one reading of a device, which has a number. */
export function Stepper({ device, reading, isLarge }) {
  const { part, capability, value } = reading;
  const [wanted, setWanted] = useState(null);
  const pressed = useRef(null); // the newest number, before it is drawn
  const timer = useRef(0);
  useEffect(() => () => clearTimeout(timer.current), []);
  const press = async (sign) => {
    const { step, least, most } = await stepsOf(device.id, part, capability).catch(() => USUAL);
    const next = Math.round(((pressed.current ?? value) + sign * step) / step) * step;
    pressed.current = Number(Math.min(most, Math.max(least, next)).toFixed(3));
    setWanted(pressed.current);
    clearTimeout(timer.current);
    timer.current = setTimeout(send, QUIET);
  };
  const send = async () => {
    const sent = pressed.current;
    await command({ id: part ? `${device.id}#${part}` : device.id, name: device.name }, "set", [{ key: capability, value: String(sent) }]);
    if (pressed.current !== sent) return; // was pressed again
    pressed.current = null;
    setWanted(null);
  };
  return html`<span class=${isLarge ? "stepper large" : "stepper"} role="group" aria-label=${`${device.name}: ${label(capability)}`}>
    <button type="button" aria-label=${say("less")} onClick=${() => press(-1)}><${Sign} path=${SIGNS.minus} /></button>
    <output class=${wanted === null ? "" : "wanted"}>${valueText(capability, wanted ?? value, unitOf({ name: capability }))}</output>
    <button type="button" aria-label=${say("more")} onClick=${() => press(1)}><${Sign} path=${SIGNS.plus} /></button>
  </span>`;
}
