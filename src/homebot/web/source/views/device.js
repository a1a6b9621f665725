// One device: its values, commands, history, what is known of it and from where, and why it is as it is.
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { Switch, command } from "../acting.js";
import { call, connection, subscribe } from "../door.js";
import { deviceOf } from "../house.js";
import { html } from "../html.js";
import { durationText, label, roundedTo, seconds, textOf, timeText, unitOf, valueText, vocabulary } from "../words.js";
import { History } from "./history.js";
import { LastKnown, Marks } from "./house.js";
import { Entry } from "./journal.js";

const WORDS = {
  on_off: ["on", "off"],
  movement: ["open", "stop", "close"],
  lock: ["lock", "unlock"],
  valve: ["open", "close"],
  push: ["press"],
};

/** Capabilities that only the name of their part tells. */
const UNNAMED = new Set(["measurement", "number", "option", "state", "text", "value"]);

/** Those that may need a code. */
const CODED = new Set(["alarm", "lock"]);

const wanted = signal(0); // grows when the device is to be asked for again

export function Device({ id }) {
  const short = deviceOf(id)?.value;
  const [full, setFull] = useState(null);
  const [why, setWhy] = useState(null);
  const isOpen = connection.value.state === "open";
  const changedAt = short?.changedAt;
  useEffect(() => {
    if (!isOpen) return undefined;
    let isCurrent = true;
    const timer = setTimeout(async () => {
      const [devices, explained] = await Promise.all([
        call("/discovery/find_devices", { ids: [id] }).catch(() => null),
        call("/control/why", { device: id }).catch(() => null),
      ]);
      if (!isCurrent) return;
      setFull(devices?.devices[0] ?? null);
      setWhy(explained);
    }, 200);
    return () => {
      isCurrent = false;
      clearTimeout(timer);
    };
  }, [id, isOpen, changedAt, wanted.value]);
  useEffect(() => subscribe("/control/events", (event) => event.device === id && (wanted.value += 1)), [id]);
  if (!short) return html`<p class="empty">There is no device ${id} (any more).</p>`;
  return html`
    <div class="title">
      <h2>${short.name} <small>${label(short.type)}${short.room && ` in ${short.room}`}</small></h2>
      <${Marks} device=${short} />
      <${Switch} device=${short} />
    </div>
    <${LastKnown} device=${short} />
    <div class="pair">
      <div>
        <${Values} short=${short} full=${full} />
        ${full && html`<${Commands} short=${short} device=${full} />`}
      </div>
      <div>
        <${History} key=${id} device=${short} />
        <${Why} id=${id} why=${why} />
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
      <th scope="row">${isTwice && !name && reading.part && `${partName(full, reading.part)} `}${name || label(reading.capability)}</th>
      <td>${valueText(reading.capability, reading.value, unit, grid[1])}</td>
      <td>${at && html`<time>since ${at}</time>`}</td>
    </tr>`;
  });
  return html`<section>
    <h3>Values</h3>
    <table class="facts">
      <tbody>
        ${rows}
      </tbody>
    </table>
  </section>`;
}

function Commands({ short, device }) {
  const found = device.parts
    .filter(({ part }) => !part.category)
    .flatMap(({ id, part }) => part.capabilities.filter((one) => one.settable).map((capability) => ({ id, part, capability })));
  const rows = found.map(({ id, part, capability }) => {
    const isTwice = found.filter((one) => one.capability.name === capability.name).length > 1;
    const name = `${isTwice && id ? `${part.name || id} ` : ""}${label(capability.name)}`;
    const now = short.states.get(`${id} ${capability.name}`)?.value;
    return html`<${Command} key=${`${id} ${capability.name}`} target=${id ? `${device.id}#${id}` : device.id} name=${name} of=${device} capability=${capability} now=${now} />`;
  });
  if (!rows.length) return null;
  return html`<section>
    <h3>Commands</h3>
    <div class="commands">${rows}</div>
  </section>`;
}

function Command({ target, name, of, capability, now }) {
  const device = { id: target, name: of.name };
  const words = WORDS[capability.name];
  if (words)
    return html`<div role="group" aria-label=${name}>
      <span>${name}</span>
      ${words.map((word) => html`<button key=${word} type="button" onClick=${(event) => command(device, word, [], codeBeside(event.currentTarget))}>${word}</button>`)}
      ${CODED.has(capability.name) && CODE}
    </div>`;
  const submit = (event) => {
    event.preventDefault();
    command(device, "set", [{ key: capability.name, value: new FormData(event.target).get("value") }], codeBeside(event.target));
  };
  const unit = unitOf(capability);
  const [least, most] = capability.bounds.length || unit !== "%" ? capability.bounds : [0, 100];
  const settable = capability.options.filter((one) => !vocabulary.value.passing[capability.name]?.includes(one));
  const field = capability.options.length
    ? html`<select name="value">
        ${settable.map((one) => html`<option key=${one} value=${one} selected=${one === now}>${textOf(capability.name, one)}</option>`)}
      </select>`
    : typeof now === "number" || most !== undefined
      ? html`<input name="value" type="number" required step="any" min=${least} max=${most} defaultValue=${typeof now === "number" ? roundedTo(now, unit, capability.grid[1]) : ""} />`
      : html`<input name="value" required />`;
  return html`<form onSubmit=${submit}>
    <label><span>${name}</span> ${field}</label>
    ${CODED.has(capability.name) && CODE}
    <button>set</button>
    <small>${most === undefined ? unit : `${least} to ${most} ${unit}`}</small>
  </form>`;
}

const CODE = html`<label>code, if it needs one <input name="code" type="password" inputmode="numeric" autocomplete="off" maxlength="255" /></label>`;

/** The code beside a button or in a form, which is used once. */
function codeBeside(element) {
  const field = element.closest("form, [role=group]").querySelector("[name=code]");
  const code = field?.value ?? "";
  if (field) field.value = "";
  return code;
}

const FINDINGS = {
  event: "Its last event, which is no state:",
  none: "It has reported no change yet.",
  heard: "It is so since homebot first heard of it.",
  retained: "A kept message says so, and not since when.",
  first: "It was so at its first report.",
};

function Why({ id, why }) {
  if (!why) return null;
  const names = new Map(why.names.map((one) => [one.key, one.value]));
  const entries = why.entries.filter((one) => one.kind !== "judged" || !one.verdicts[0]?.allowed);
  return html`<section>
    <h3>Why</h3>
    <p>${why.success ? (FINDINGS[why.finding] ?? `It changed at ${timeText(why.changed_at)}.`) : why.message}</p>
    <ol class="log">
      ${entries.map((one, index) => html`<${Entry} key=${index} entry=${one} own=${id} names=${names} />`)}
    </ol>
  </section>`;
}

function Facts({ device }) {
  const unreadable = device.facts.filter((fact) => fact.name === "unreadable");
  const age = Date.now() / 1000 - seconds(device.last_seen);
  return html`<section>
    <h3>What is known, and from where</h3>
    ${unreadable.map((fact) => html`<p class="bad" key=${fact.key + fact.value}>Not understood at ${timeText(fact.said_at)}: ${fact.value}</p>`)}
    <table class="facts">
      <tbody>
        ${known("id", device.id)}
        ${known("last seen", `${durationText(Math.max(age, 0))} ago`, device.freshness === "unconfirmed" ? "last known" : device.freshness)}
        ${device.facts.filter((fact) => !unreadable.includes(fact)).map((fact) => known(label(fact.name), fact.value, fact.convention === "owner" ? `you, by the ${fact.key}` : [fact.gateway, fact.convention].filter(Boolean).join(", ")))}
        ${device.endpoints.map((one) => known("reached by", `${one.gateway}: ${topic(one.address) || one.key}`, topic(one.command_address)))}
        ${device.conflicts.map((text) => known("conflict", text))}
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

const partName = (full, id) => full?.parts.find((one) => one.id === id)?.part.name || id;
