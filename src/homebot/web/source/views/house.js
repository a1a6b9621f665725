// The house by room, live.
import { computed, signal } from "@preact/signals";
import { Component } from "preact";
import { Switch } from "../acting.js";
import { count, deviceOf, isLoaded, rooms } from "../house.js";
import { html } from "../html.js";
import { hasWords, label, summary } from "../words.js";

const MANY = 30; // devices from which on they can be searched

const sought = signal("");
const found = computed(() => {
  if (!sought.value.trim()) return rooms.value;
  const fits = (id, room) => {
    const { name = "", type = "" } = deviceOf(id)?.peek() ?? {};
    return hasWords(`${name} ${label(type)} ${room}`, sought.value);
  };
  return rooms.value.map(([room, ids]) => [room, ids.filter((id) => fits(id, room))]).filter(([, ids]) => ids.length);
});

export function House() {
  if (!isLoaded.value) return html`<p class="empty">Asking homebot for its devices …</p>`;
  if (!count.value)
    return html`<p class="empty">No device is known yet. They appear here as the gateways find them.</p>`;
  return html`
    ${count.value > MANY && html`<p class="choices"><label>Search <input type="search" value=${sought.value} onInput=${(event) => (sought.value = event.target.value)} /></label></p>`}
    ${!found.value.length && html`<p class="empty">No device has these words in its name, type or room.</p>`}
    <${LastKnown} />
    <div class="rooms">
      ${found.value.map(
        ([room, ids]) => html`<section class="room" key=${room}>
          <h2>${room || "Without a room"} <small>${ids.length}</small></h2>
          <table>
            <colgroup><col class="name" /><col /><col class="act" /></colgroup>
            <thead class="hidden">
              <tr>
                <th>Device</th>
                <th>State</th>
                <th>Switch</th>
              </tr>
            </thead>
            <tbody>
              ${ids.map((id) => html`<${Row} key=${id} id=${id} />`)}
            </tbody>
          </table>
        </section>`,
      )}
    </div>`;
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
  const device = deviceOf(id)?.value;
  if (!device) return null;
  return html`<tr>
    <th scope="row">
      <a href=${`#/device/${encodeURIComponent(id)}`}>${device.name}</a>
      <small>${label(device.type)}</small>
    </th>
    <td>${summary(device)} <${Marks} device=${device} /></td>
    <td><${Switch} device=${device} /></td>
  </tr>`;
}

const isLastKnown = (device) => device.is_reachable && device.freshness === "unconfirmed" && [...device.states.values()].some((one) => one.value !== null);
const someAreLastKnown = computed(() => rooms.value.some(([, ids]) => ids.some((id) => isLastKnown(deviceOf(id).value))));

/** What "last known" means, once on a view where a device has that mark. */
export function LastKnown({ device }) {
  return (device ? isLastKnown(device) : someAreLastKnown.value) && html`<p class="legend"><span class="mark">last known</span> was kept from before: the device has not reported since homebot started.</p>`;
}

export function Marks({ device }) {
  const marks = [];
  if (!device.is_reachable) marks.push(["bad", "unreachable"]);
  else if (device.freshness === "stale") marks.push(["bad", "silent"]);
  else if (isLastKnown(device)) marks.push(["", "last known"]);
  if (device.waits) marks.push(["", "not approved"]);
  return marks.map(([kind, text]) => html`<span class=${`mark ${kind}`} key=${text}>${text}</span>`);
}
