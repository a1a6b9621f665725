// The alarm panel: its modes as large buttons, and a keypad where it takes a code.
import { useState } from "preact/hooks";
import { codeOf, isGuarded, perform, setting } from "../acts.js";
import { read, takes } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { Keypad } from "../keypad.js";
import { say } from "../language.js";
import { HoldButton } from "../touch.js";
import { capital, textOf } from "../words.js";

const MODES = ["disarmed", "armed_home", "armed_night", "armed_away"];
const text = (mode) => textOf("alarm", mode);

function Main({ device }) {
  const [asked, setAsked] = useState("");
  const now = read(device, "alarm");
  const codes = codeOf(device, { capability: "alarm" });
  const actOf = (mode) => setting(text(mode), "alarm", mode, mode === "disarmed");
  const start = (mode, isHeld) => {
    if (codes) setAsked(mode);
    else perform(device, actOf(mode), { isHeld });
  };
  if (!takes(device, "alarm")) return null;
  return html`<div class="modes" role="group" aria-label=${device.name}>
      ${MODES.map((mode) =>
        isGuarded(device, actOf(mode)) && mode !== now && !codes
          ? html`<${HoldButton} key=${mode} text=${say("disarm")} onHeld=${() => start(mode, true)} />`
          : html`<button key=${mode} type="button" class=${mode} aria-pressed=${String(mode === now)} onClick=${() => mode !== now && start(mode, false)}><${Sign} path=${SIGNS[mode]} /> ${capital(text(mode))}</button>`,
      )}
    </div>
    ${asked && html`<${Keypad} text=${asked === "disarmed" ? say("disarm") : text(asked)} kind=${codes} isHeld=${isGuarded(device, actOf(asked))} onDone=${(code) => { setAsked(""); perform(device, actOf(asked), { isHeld: true, code }); }} onCancel=${() => setAsked("")} />`}`;
}

export const alarm = {
  types: ["x_alarm_panel"],
  group: "doors",
  isActive: (device) => read(device, "alarm") !== "disarmed",
  tone: (device) => ({ disarmed: "rest", triggered: "alarm", arming: "on", pending: "on" })[read(device, "alarm") ?? "disarmed"] ?? "secure",
  state: (device) => text(read(device, "alarm") ?? "unknown"),
  Main,
  main: ["alarm"],
};
