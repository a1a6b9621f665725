// What heats and cools: the measured temperature, and a large one that is set.
import { act, perform } from "../acts.js";
import { Choice } from "../buttons.js";
import { read, readingOf, takes } from "../house.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { Stepper, stepped } from "../stepper.js";
import { capital, textOf, valueText } from "../words.js";
import { switched } from "./switch.js";

const WARM = new Set(["heating", "preheating"]);
const COLD = new Set(["cooling"]);
const MODES = [["thermostat_mode", "off", "heat", "cool", "auto", "dry", "fan_only"]];

const action = (device) => read(device, "thermostat_action");
const measured = (device) => ["local_temperature", "temperature", "humidity"].map((one) => readingOf(device, one)).find(Boolean);

function tone(device) {
  if (WARM.has(action(device))) return "heat";
  if (COLD.has(action(device))) return "cool";
  return "rest";
}

/** Measured, then what is set, which has the buttons of the tile. */
function state(device) {
  const now = measured(device);
  return now ? valueText(now.capability, now.value) : textOf("thermostat_mode", read(device, "thermostat_mode") ?? "unknown");
}

function Main({ device }) {
  const reading = stepped(device);
  const mode = read(device, "thermostat_mode");
  const [[capability, ...modes]] = MODES;
  const known = takes(device, capability) ? modes.filter((one) => one === mode || one === "off" || (one === "heat" && takes(device, "heating_setpoint")) || (one === "cool" && takes(device, "cooling_setpoint"))) : [];
  return html`<div class="setpoint">
      ${reading ? html`<${Stepper} device=${device} reading=${reading} isLarge />` : html`<output><b>${state(device)}</b></output>`}
      <p>${[measured(device) && say("now {value}", { value: state(device) }), action(device) && textOf("thermostat_action", action(device))].filter(Boolean).join(" · ")}</p>
    </div>
    ${known.length > 1 && html`<${Choice} device=${device} capability=${capability} options=${known} />`}
    ${takes(device, "on_off") && known.length < 2 && html`<div class="solo"><button type="button" class="chief" role="switch" aria-checked=${String(Boolean(read(device, "on_off")))} onClick=${() => perform(device, act("", read(device, "on_off") ? "off" : "on", "on_off", true))}>${capital(say(read(device, "on_off") ? "on" : "off"))}</button></div>`}`;
}

export const climate = {
  types: ["thermostat", "room_air_conditioner", "water_heater"],
  group: "climate",
  isActive: (device) => tone(device) !== "rest" || (read(device, "thermostat_mode") ?? read(device, "water_heater_mode") ?? "off") !== "off",
  tone,
  state,
  Main,
  main: ["heating_setpoint", "cooling_setpoint", "humidity_setpoint", "on_off"],
};

/** What makes the air wetter or drier: it is switched too. */
export const humidifier = { ...climate, types: ["x_humidifier"], isActive: switched.isActive, isSwitch: true, tone: switched.tone, state: (device) => (switched.isActive(device) && measured(device) ? state : switched.state)(device), act: switched.act };
