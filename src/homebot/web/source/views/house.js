// The house by room, live, and one room of it, as for a tablet at its wall.
import { computed, signal } from "@preact/signals";
import { Component } from "preact";
import { useEffect, useState } from "preact/hooks";
import { Alerts } from "../alerts.js";
import { Controls } from "../controls.js";
import { call, may } from "../door.js";
import { count, deviceOf, isHidden, isLoaded, rooms } from "../house.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { Owner } from "../owner.js";
import { Quick, stepped } from "../quick.js";
import { Scenes } from "../scenes.js";
import { hasWords, label, summary, titled } from "../words.js";

const MANY = 30; // devices from which on they can be searched

const sought = signal("");
const showsHidden = signal(false);
const hidden = computed(() => rooms.value.flatMap(([, ids]) => ids.filter(isHidden)).length);
const found = computed(() => {
  const fits = (id, room) => {
    if (!showsHidden.value && isHidden(id)) return false;
    const { name = "", given = "", type = "" } = deviceOf(id)?.peek() ?? {};
    return !sought.value.trim() || hasWords(`${name} ${given} ${label(type)} ${room}`, sought.value);
  };
  return rooms.value.map(([room, ids]) => [room, ids.filter((id) => fits(id, room))]).filter(([, ids]) => ids.length);
});

export function House() {
  if (!isLoaded.value) return html`<p class="empty">${say("Asking homebot for its devices …")}</p>`;
  return html`
    <${Alerts} />
    <${Scenes} />
    ${!count.value && html`<p class="empty">${say("No device is known yet. They appear here as the gateways find them.")}</p>`}
    ${count.value > MANY && html`<p class="choices"><label>${say("Search")} <input type="search" value=${sought.value} onInput=${(event) => (sought.value = event.target.value)} /></label></p>`}
    ${count.value > 0 && !found.value.length && html`<p class="empty">${say("No device has these words in its name, type or room.")}</p>`}
    <${LastKnown} />
    <div class="rooms">${found.value.map(([room, ids]) => html`<${Devices} key=${room} room=${room} ids=${ids} />`)}</div>
    ${hidden.value > 0 && html`<p class="choices"><button type="button" aria-pressed=${showsHidden.value} onClick=${() => (showsHidden.value = !showsHidden.value)}>${say("show {count} hidden", { count: hidden.value })}</button></p>`}`;
}

/** One room, which the address names. */
export function Room({ id }) {
  const [room, ids] = rooms.value.find(([name]) => name.toLowerCase() === id.toLowerCase()) ?? [];
  if (!isLoaded.value) return html`<p class="empty">${say("Asking homebot for its devices …")}</p>`;
  return html`<div class="wall">
    <${Alerts} />
    <${Scenes} room=${id} />
    ${ids ? html`<${Devices} room=${room} ids=${ids.filter((one) => !isHidden(one))} />` : html`<p class="empty">${say("There is no device in a room {room}.", { room: id })}</p>`}
  </div>`;
}

function Devices({ room, ids }) {
  return html`<section class="room">
    <h2>${room ? html`<a href=${`#/room/${encodeURIComponent(room)}`}>${titled(room)}</a>` : say("Without a room")} <small>${ids.length}</small></h2>
    <ul class="devices">${ids.map((id) => html`<${Row} key=${id} id=${id} />`)}</ul>
  </section>`;
}

/** A row is rendered again by its own signal alone, never by the list. */
class Row extends Component {
  shouldComponentUpdate() {
    return false;
  }

  render({ id }) {
    return html`<${Cells} id=${id} />`;
  }
}

function Cells({ id }) {
  const [isOpen, setIsOpen] = useState(false);
  const device = deviceOf(id)?.value;
  if (!device) return null;
  return html`<li>
    <span class="who">
      <a href=${`#/device/${encodeURIComponent(id)}`}><bdi>${device.name}</bdi></a>
      <small>${label(device.type)}</small>
    </span>
    <span>${summary(device, stepped(device))} <${Marks} device=${device} /></span>
    <span class="act">
      <${Quick} device=${device} />
      ${may("act") && html`<button type="button" class="more" aria-expanded=${isOpen} aria-label=${say("more of {name}", { name: device.name })} onClick=${() => setIsOpen(!isOpen)}>⋮</button>`}
    </span>
    ${isOpen && html`<${More} id=${id} short=${device} />`}
  </li>`;
}

/** All controls of a device, and what the owner says of it. */
function More({ id, short }) {
  const [full, setFull] = useState(null);
  useEffect(() => {
    call("/discovery/find_devices", { ids: [id] }).then((answer) => setFull(answer.devices[0]), () => {});
  }, [id]);
  return html`<div class="opened">
    ${full && html`<${Controls} short=${short} device=${full} />`}
    <details><summary>${say("Name, room and tags")}</summary><${Owner} device=${short} /></details>
  </div>`;
}

const isLastKnown = (device) => device.is_reachable && device.freshness === "unconfirmed" && [...device.states.values()].some((one) => one.value !== null);
const someAreLastKnown = computed(() => rooms.value.some(([, ids]) => ids.some((id) => isLastKnown(deviceOf(id).value))));

/** What "last known" means, once on a view where a device has that mark. */
export function LastKnown({ device }) {
  return (device ? isLastKnown(device) : someAreLastKnown.value) && html`<p class="legend"><span class="mark">${say("last known")}</span> ${say("was kept from before: the device has not reported since homebot started.")}</p>`;
}

export function Marks({ device }) {
  const marks = [];
  if (!device.is_reachable) marks.push(["bad", "unreachable"]);
  else if (device.freshness === "stale") marks.push(["bad", "silent"]);
  else if (isLastKnown(device)) marks.push(["", "last known"]);
  if (device.waits) marks.push(["", "not approved"]);
  return marks.map(([kind, text]) => html`<span class=${`mark ${kind}`} key=${text}>${say(text)}</span>`);
}
