// The control in the row of a device, for what is done most often with it; what can hurt has none.
import { command } from "./acting.js";
import { may } from "./door.js";
import { html } from "./html.js";
import { say } from "./language.js";
import { Stepper } from "./stepper.js";

const SWITCHED = new Set(["light", "plug", "switch", "fan", "on_off_light", "on_off_plug", "outlet"]);
const COVER = [["open", "▲"], ["stop", "■"], ["close", "▼"]];
const SETPOINTS = ["heating_setpoint", "cooling_setpoint", "humidity_setpoint"];
const PRESSED = ["scene", "push"];

/** The reading that has a button for less and one for more: the only setpoint. */
export function stepped(device) {
  const found = [...device.states.values()].filter((one) => SETPOINTS.includes(one.capability) && typeof one.value === "number" && device.settable.includes(one.capability));
  return found.length === 1 ? found[0] : undefined;
}

export function Quick({ device }) {
  if (!may("act")) return null;
  const states = [...device.states.values()];
  const takes = (name) => device.settable.includes(name);
  const isOn = states.find((one) => one.capability === "on_off")?.value;
  if (typeof isOn === "boolean" && SWITCHED.has(device.type))
    return html`<button type="button" class="switch" role="switch" aria-checked=${String(isOn)} aria-label=${device.name} onClick=${() => command(device, isOn ? "off" : "on")}></button>`;
  if (device.type === "window_covering" && (takes("movement") || takes("position")))
    return html`<span class="buttons" role="group" aria-label=${device.name}>
      ${COVER.filter(([word]) => word !== "stop" || takes("movement")).map(([word, sign]) => html`<button key=${word} type="button" aria-label=${say(`${word}|do`)} onClick=${() => command(device, word)}>${sign}</button>`)}
    </span>`;
  const reading = stepped(device);
  if (reading) return html`<${Stepper} device=${device} reading=${reading} />`;
  if (!states.length && PRESSED.some(takes)) return html`<button type="button" aria-label=${`${say("press|do")}: ${device.name}`} onClick=${() => command(device, "press")}>${say("press|do")}</button>`;
  return null;
}
