// Security: the house in one sentence, each door and window as a large state, the alarm, cameras, smoke, water and motion.
import { useState } from "preact/hooks";
import { Added } from "../added.js";
import { ActButton } from "../buttons.js";
import { call } from "../door.js";
import { shown } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign, thingOf, thingSigns } from "../icons.js";
import { kindOf, signOf, stateOf, toneOf } from "../kinds.js";
import { say } from "../language.js";
import { second } from "../later.js";
import { useOpen } from "../opened.js";
import { isOpen, placeName } from "../summaries.js";
import { Picture, hasPicture, isOfDevice, named } from "../picture.js";
import { Tile, openSheet } from "../tile.js";
import { capital, titled } from "../words.js";

const HAZARDS = new Set(["smoke_co_alarm", "water_leak_detector", "water_freeze_detector", "occupancy_sensor", "siren"]);
const Lately = second("Lately");

/** Doors, each with its contact and its lock where places or equal names tell them; a lock without a door is one too. */
function doorsOf(devices, places) {
  const guards = devices.filter((one) => kindOf(one).group === "doors" && one.type !== "x_alarm_panel");
  const locks = guards.filter((one) => one.type === "door_lock");
  const words = (device) => device.name.toLowerCase().replace(/[^\p{L}\d]/gu, " ").split(" ").filter(Boolean);
  const isOf = (lock, door) =>
    places.some((one) => one.contact === door.id && one.lock === lock.id) || (lock.room === door.room && words(door).every((word) => words(lock).includes(word)));
  const doors = guards.filter((one) => one.type !== "door_lock").map((device) => ({ device, lock: locks.find((lock) => isOf(lock, device)) }));
  const taken = new Set(doors.map(({ lock }) => lock));
  return [...doors, ...locks.filter((lock) => !taken.has(lock)).map((lock) => ({ device: lock }))];
}

const isDoorOpen = ({ device, lock }) => isOpen(device) || Boolean(lock && isOpen(lock));

export function Security() {
  const [places, setPlaces] = useState([]);
  useOpen(() => void call("/discovery/places").then((answer) => setPlaces(answer.doors), () => {}));
  const devices = shown.value;
  const doors = doorsOf(devices, places);
  const open = doors.filter(isDoorOpen);
  const silent = doors.filter(({ device }) => toneOf(device) === "silent");
  const order = [...open, ...doors.filter((one) => !isDoorOpen(one))];
  const hazards = devices.filter((one) => HAZARDS.has(one.type)).sort((a, b) => (toneOf(b) === "alarm") - (toneOf(a) === "alarm"));
  const panels = devices.filter((one) => one.type === "x_alarm_panel");
  const cameras = [...devices.filter(hasPicture).map((device) => ({ name: device.name, of: device.id, sign: signOf(device) })), ...named.value.filter((name) => !isOfDevice(devices, name)).map((name) => ({ name, of: name, sign: thingSigns("camera")[0] }))];
  return html`
    <h1 class="hidden">${say("Security")}</h1>
    <${Added} at="top" />
    ${doors.length > 0 && html`<section class=${open.length ? "banner open" : "banner secure"} role="status"><${Sign} path=${!open.length ? SIGNS.shield : isOpen(open[0].device) ? (SIGNS[thingOf(open[0].device)] ?? SIGNS.lock) : SIGNS.lock} size=${56} />
      <div><h2>${say(open.length ? "The house is open" : "The house is closed")}</h2><p>${[open.map(({ device }) => placeName(device)).join(", "), silent.length > 0 && say("not known: {names}", { names: silent.map(({ device }) => placeName(device)).join(", ") })].filter(Boolean).join(" · ")}</p></div></section>`}
    <div class=${panels.length + cameras.length ? "securitygrid sided" : "securitygrid"}>
      <div class="column">
        ${doors.length > 0 && html`<section aria-labelledby="doors"><h2 id="doors">${say("Doors and windows")}</h2><div class="guards">${order.map((one) => html`<${Guard} key=${one.device.id} door=${one} />`)}</div></section>`}
        ${hazards.length > 0 && html`<section class="hazards" aria-labelledby="hazards"><h2 id="hazards">${say("Smoke, water, motion")}</h2><div class="tiles">${hazards.map((one) => html`<${Tile} key=${one.id} id=${one.id} room=${one.room} />`)}</div></section>`}
        <${Lately} title=${say("Lately")} among=${1000} most=${8} ids=${doors.flatMap(({ device, lock }) => [device.id, ...(lock ? [lock.id] : [])]).concat(panels.map((one) => one.id))} />
      </div>
      ${panels.length + cameras.length > 0 && html`<div class="column">
        ${panels.map((one) => html`<${Panel} key=${one.id} device=${one} />`)}
        ${cameras.map(({ name, of, sign }) => html`<section key=${of} class="card" aria-label=${name}><h2><span class="icon"><${Sign} path=${sign} /></span> <bdi>${name}</bdi>${of !== name && html`<button type="button" class="round more" aria-label=${say("more of {name}", { name })} onClick=${() => openSheet(of)}><${Sign} path=${SIGNS.right} /></button>`}</h2><${Picture} of=${of} text=${name} /></section>`)}
      </div>`}
    </div>
    ${!doors.length && !hazards.length && !panels.length && !cameras.length && html`<p class="empty">${say("There is no lock, contact or alarm yet.")}</p>`}`;
}

function Panel({ device }) {
  const { Main } = kindOf(device);
  return html`<section class="card" aria-label=${device.name}><h2><span class=${`icon ${toneOf(device)}`}><${Sign} path=${signOf(device)} /></span> <bdi>${device.name}</bdi> <small>${stateOf(device)}</small></h2>${device.may_act && html`<${Main} device=${device} />`}</section>`;
}

/** A door as a large tile: the state first; what opens the house is held. */
function Guard({ door }) {
  const { device, lock } = door;
  const acting = lock ?? device;
  const act = acting.may_act ? kindOf(acting).act?.(acting) : null;
  const tone = isDoorOpen(door) ? "open" : toneOf(device) === "silent" ? "silent" : "secure";
  const state = [kindOf(device).state(device), lock && kindOf(lock).state(lock)].filter(Boolean).join(", ");
  const [, since] = stateOf(device).split(kindOf(device).state(device));
  return html`<div class=${`guard ${tone}`}>
    <button type="button" class="about" onClick=${() => openSheet(device.id)}><span class="icon"><${Sign} path=${signOf(device)} size=${32} /></span>
      <span class="state">${capital(state)}</span><span class="name"><bdi>${placeName(device)}</bdi> <small>${[titled(device.room), tone === "open" && since?.trim()].filter(Boolean).join(" · ")}</small></span></button>
    ${act && html`<${ActButton} device=${acting} act=${act} name="wide" />`}
  </div>`;
}
