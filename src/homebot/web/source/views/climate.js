// Climate: each room with what is measured, what is set, what heats, and windows that are open beside heating.
import { Added } from "../added.js";
import { read } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign, roomSign, thingOf } from "../icons.js";
import { kindOf, signOf, stateOf, toneOf } from "../kinds.js";
import { say } from "../language.js";
import { Stepper, stepped } from "../stepper.js";
import { airOf, isOpen, isOutside, roomList, temperatureText } from "../summaries.js";
import { openSheet } from "../tile.js";
import { label, titled, valueText } from "../words.js";

const AIR = ["humidity", "carbon_dioxide", "pm25", "volatile_organic_compounds", "air_quality_index"];

export function Climate() {
  const rooms = roomList.value.map(([room, devices]) => ({ room, devices, warm: airOf(devices), heaters: devices.filter((one) => kindOf(one).group === "climate") })).filter(({ devices, warm, heaters }) => warm !== undefined || heaters.length || airOf(devices, ["humidity"]) !== undefined);
  const inside = rooms.flatMap(({ devices }) => devices.filter((one) => !isOutside(one)));
  const outside = airOf(rooms.flatMap(({ devices }) => devices.filter(isOutside)), ["temperature"]);
  const home = airOf(inside);
  const wasting = rooms.filter(isWasting);
  return html`
    <header class="top"><h1>${say("Climate")}</h1>
      <p class="air">${home !== undefined && html`<span><${Sign} path=${SIGNS.home} size=${22} /> ${temperatureText(home)}</span>`} ${outside !== undefined && html`<span><${Sign} path=${SIGNS.climate} size=${22} /> ${temperatureText(outside)} ${say("outside")}</span>`}</p></header>
    ${wasting.length > 0 && html`<section class="banner open" role="status"><${Sign} path=${SIGNS.window} size=${48} /><div><h2>${say("It heats beside an open window")}</h2><p>${wasting.map(({ room }) => titled(room)).join(", ")}</p></div></section>`}
    ${!rooms.length && html`<p class="empty">${say("No device tells a temperature yet.")}</p>`}
    <div class="climates">${rooms.map((one) => html`<${RoomClimate} key=${one.room} ...${one} />`)}</div>`;
}

const isWasting = ({ devices, heaters }) => heaters.some((one) => ["heat", "cool"].includes(toneOf(one))) && devices.some((one) => isOpen(one) && ["window", "door"].includes(thingOf(one)));

function RoomClimate({ room, devices, warm, heaters }) {
  const tone = heaters.map(toneOf).find((one) => one === "heat" || one === "cool") ?? "rest";
  const others = AIR.map((capability) => [capability, devices.map((one) => read(one, capability)).find((value) => typeof value === "number")]).filter(([, value]) => value !== undefined);
  const open = devices.filter((one) => isOpen(one));
  const source = devices.find((one) => read(one, "local_temperature") !== undefined) ?? devices.find((one) => read(one, "temperature") !== undefined);
  return html`<section class=${`card climate ${tone}`} aria-label=${titled(room)}>
    <h2><span class=${`icon ${tone}`}><${Sign} path=${heaters[0] ? signOf(heaters[0]) : roomSign(room)} /></span> <a href=${`#/room/${encodeURIComponent(room)}`}>${room ? titled(room) : say("Without a room")}</a> ${open.length > 0 && html`<span class="mark open"><${Sign} path=${SIGNS.window} size=${20} /><span class="hidden">${say("{name} open", { name: open[0].name })}</span></span>`}</h2>
    <p class="number"><b>${warm === undefined ? "–" : temperatureText(warm)}</b> <span>${others.map(([capability, value]) => `${label(capability)} ${valueText(capability, value)}`).join(" · ")}</span></p>
    ${heaters.map((one) => html`<div key=${one.id} class="heater"><p><button type="button" class="link" onClick=${() => openSheet(one.id)}>${one.name}</button> <small>${stateOf(one)}</small></p>${one.may_act && stepped(one) ? html`<${Stepper} device=${one} reading=${stepped(one)} />` : ""}</div><${Added} at="next" device=${one} />`)}
    ${source && html`<${Added} at="day" device=${source} capability=${read(source, "local_temperature") !== undefined ? "local_temperature" : "temperature"} />`}
  </section>`;
}
