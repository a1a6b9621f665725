// The house by room, live.
import { Component } from "preact";
import { Switch } from "../acting.js";
import { count, deviceOf, isLoaded, rooms } from "../house.js";
import { html } from "../html.js";
import { label, summary } from "../words.js";

export function House() {
  if (!isLoaded.value) return html`<p class="empty">Asking homebot for its devices …</p>`;
  if (!count.value)
    return html`<p class="empty">No device is known yet. They appear here as the gateways find them.</p>`;
  return html`<div class="rooms">
    ${rooms.value.map(
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

export function Marks({ device }) {
  const marks = [];
  if (!device.is_reachable) marks.push(["bad", "unreachable"]);
  else if (device.freshness === "stale") marks.push(["bad", "silent"]);
  else if (device.freshness === "unconfirmed") marks.push(["", "unconfirmed"]);
  if (device.waits) marks.push(["", "not approved"]);
  return marks.map(([kind, text]) => html`<span class=${`mark ${kind}`} key=${text}>${text}</span>`);
}
