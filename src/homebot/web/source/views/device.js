// All of one device: its values, commands, history, what is known of it and from where, and why it is as it is.
import { Added } from "../added.js";
import { now } from "../clock.js";
import { Controls } from "../controls.js";
import { may } from "../door.js";
import { deviceOf, isLoaded } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { stateOf } from "../kinds.js";
import { say } from "../language.js";
import { Lacking } from "../managing.js";
import { LastKnown, Marks } from "../marks.js";
import { useFull } from "../options.js";
import { Owner } from "../owner.js";
import { openSheet } from "../tile.js";
import { Why } from "../why.js";
import { UNNAMED, durationText, label, seconds, timeText, titled, valueText } from "../words.js";

export function Device({ id }) {
  const short = deviceOf(id)?.value;
  const full = useFull(id, true, short?.changedAt);
  if (!short) return isLoaded.value && html`<h1><bdi>${id}</bdi></h1><p class="empty">${say("There is no device {name} (any more).", { name: id })}</p>`;
  return html`
    <div class="title">
      <h1>${short.name} <small>${label(short.type)}${short.room && `, ${titled(short.room)}`}</small></h1>
      <${Marks} device=${short} />
      <button type="button" class="pill" onClick=${() => openSheet(id)}>${stateOf(short)} <${Sign} path=${SIGNS.right} /></button>
    </div>
    <${LastKnown} device=${short} />
    <div class="pair">
      <div>
        <${Values} short=${short} full=${full} />
        ${full && html`<${Commands} short=${short} device=${full} />`}
        <section>
          <h2>${say("Name, room and tags")}</h2>
          <${Owner} device=${short} />
        </section>
      </div>
      <div>
        <${Added} key=${id} at="device" device=${short} />
        <${Why} device=${short} />
      </div>
    </div>
    ${full && html`<${Facts} device=${full} />`}
  `;
}

function Values({ short, full }) {
  const since = new Map((full?.states ?? []).map((one) => [`${one.part} ${one.capability}`, one]));
  const readings = [...short.states];
  const rows = readings.map(([key, reading]) => {
    const state = since.get(key);
    const at = state ? timeText(state.since) : "";
    const { unit, grid = [] } = capabilityOf(full, reading) ?? {};
    const name = UNNAMED.has(reading.capability) && partName(full, reading.part);
    const isTwice = readings.filter(([, one]) => one.capability === reading.capability).length > 1;
    return html`<tr key=${key}>
      <th scope="row">${isTwice && !name && reading.part && `${partName(full, reading.part) || reading.part} `}${name || label(reading.capability)}</th>
      <td>${valueText(reading.capability, reading.value, unit, grid[1])}</td>
      <td>${at && html`<time>${say("since {time}", { time: at })}</time>`}</td>
    </tr>`;
  });
  return html`<section>
    <h2>${say("Values")}</h2>
    <table class="facts">
      <tbody>
        ${rows}
      </tbody>
    </table>
  </section>`;
}

function Commands({ short, device }) {
  if (!may("act")) return html`<${Lacking} right="act" />`;
  if (!device.parts.some(({ part }) => !part.category && part.capabilities.some((one) => one.settable))) return null;
  return html`<section>
    <h2>${say("Commands")}</h2>
    <${Controls} short=${short} device=${device} />
  </section>`;
}

function Facts({ device }) {
  const unreadable = device.facts.filter((fact) => fact.name === "unreadable");
  const age = now() - seconds(device.last_seen);
  return html`<section>
    <h2>${say("What is known, and from where")}</h2>
    ${unreadable.map((fact) => html`<p class="bad" key=${fact.key + fact.value}>${say("Not understood at {time}:", { time: timeText(fact.said_at) })} ${fact.value}</p>`)}
    <table class="facts">
      <tbody>
        ${known("id", device.id)}
        ${known(say("last seen"), say("{time} ago", { time: durationText(Math.max(age, 0)) }), say(device.freshness === "unconfirmed" ? "last known" : device.freshness))}
        ${device.facts.filter((fact) => !unreadable.includes(fact)).map((fact) => known(label(fact.name), fact.value, fact.convention === "owner" ? say("you, by {what}", { what: fact.key }) : [fact.gateway, fact.convention].filter(Boolean).join(", ")))}
        ${device.endpoints.map((one) => known(say("reached by"), `${one.gateway}: ${topic(one.address) || one.key}`, topic(one.command_address)))}
        ${device.conflicts.map((text) => known(say("conflict"), text))}
      </tbody>
    </table>
  </section>`;
}

const topic = (address) => (address.startsWith("words:") ? "" : address); // the others are homebot's own

const known = (name, value, source = "") => html`<tr><th scope="row">${name}</th><td>${value} <small>${source}</small></td></tr>`;

function capabilityOf(full, reading) {
  const part = full?.parts.find((one) => one.id === reading.part);
  return part?.part.capabilities.find((one) => one.name === reading.capability);
}

const partName = (full, id) => full?.parts.find((one) => one.id === id)?.part.name;
