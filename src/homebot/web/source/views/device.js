// One device: its values, commands, history, what is known of it and from where, and why it is as it is.
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { command } from "../acting.js";
import { call, connection, subscribe } from "../door.js";
import { deviceOf } from "../house.js";
import { html } from "../html.js";
import { Plot } from "../plot.js";
import { durationText, entryText, label, seconds, timeText, valueText } from "../words.js";
import { Marks } from "./house.js";

const WORDS = {
  on_off: ["on", "off"],
  movement: ["open", "stop", "close"],
  lock: ["lock", "unlock"],
  valve: ["open", "close"],
  push: ["press"],
};
const PERIODS = [["1 h", 3600], ["24 h", 86_400], ["7 d", 604_800], ["30 d", 2_592_000], ["1 y", 31_536_000]]; // seconds

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
    <h2>${short.name} <small>${label(short.type)}${short.room && ` in ${short.room}`}</small></h2>
    <p><${Marks} device=${short} /></p>
    <${Values} short=${short} full=${full} />
    ${full && html`<${Commands} device=${full} />`}
    <${Why} why=${why} />
    <${History} key=${id} short=${short} />
    ${full && html`<${Facts} device=${full} />`}
  `;
}

function Values({ short, full }) {
  const since = new Map((full?.states ?? []).map((one) => [`${one.part} ${one.capability}`, one]));
  const hasSeveral = new Set([...short.states.values()].map((one) => one.part)).size > 1;
  const rows = [...short.states].map(([key, reading]) => {
    const state = since.get(key);
    const at = state ? timeText(state.since) : "";
    const unit = capabilityOf(full, reading)?.unit;
    return html`<tr key=${key}>
      <th scope="row">${hasSeveral && reading.part && `${partName(full, reading.part)} `}${label(reading.capability)}</th>
      <td>${valueText(reading.capability, reading.value, unit)}</td>
      <td>${at && `since ${at}`}</td>
    </tr>`;
  });
  return html`<section aria-label="values">
    <table class="facts">
      <tbody>
        ${rows}
      </tbody>
    </table>
  </section>`;
}

function Commands({ device }) {
  const rows = [];
  for (const { id, part } of device.parts) {
    if (part.category) continue;
    const target = id ? `${device.id}#${id}` : device.id;
    for (const capability of part.capabilities) {
      if (!capability.settable) continue;
      const name = `${id && device.parts.length > 1 ? `${part.name || id} ` : ""}${label(capability.name)}`;
      rows.push(html`<${Command} key=${`${id} ${capability.name}`} target=${target} name=${name} of=${device} capability=${capability} />`);
    }
  }
  if (!rows.length) return null;
  return html`<section>
    <h3>Commands</h3>
    <div class="commands">${rows}</div>
  </section>`;
}

function Command({ target, name, of, capability }) {
  const device = { id: target, name: of.name };
  const set = (value) => command(device, "set", [{ key: capability.name, value }]);
  const words = WORDS[capability.name];
  if (words)
    return html`<div role="group" aria-label=${name}>
      <span>${name}</span>
      ${words.map((word) => html`<button key=${word} type="button" onClick=${() => command(device, word)}>${word}</button>`)}
    </div>`;
  const submit = (event) => {
    event.preventDefault();
    set(new FormData(event.target).get("value"));
  };
  const [least, most] = capability.bounds;
  const field = capability.options.length
    ? html`<select name="value">
        ${capability.options.map((one) => html`<option key=${one}>${one}</option>`)}
      </select>`
    : html`<input name="value" required size="8" inputmode="decimal" placeholder=${most === undefined ? "" : `${least} … ${most}`} />`;
  return html`<form onSubmit=${submit}>
    <label><span>${name}</span> ${field} ${capability.unit}</label>
    <button>set</button>
  </form>`;
}

const FINDINGS = {
  none: "It has reported no change yet.",
  heard: "It is so since homebot first heard of it.",
  retained: "A kept message says so, and not since when.",
  first: "It was so at its first report.",
};

function Why({ why }) {
  if (!why) return null;
  const names = new Map(why.names.map((one) => [one.key, one.value]));
  return html`<section>
    <h3>Why</h3>
    ${why.success ? html`<p>${FINDINGS[why.finding] ?? `It changed at ${timeText(why.changed_at)}.`}</p>` : html`<p>${why.message}</p>`}
    <ol class="entries">
      ${why.entries
        .filter((one) => one.kind !== "judged" || !one.verdicts[0]?.allowed)
        .map((one, index) => html`<li key=${index}><time>${timeText(one.at)}</time> ${names.get(one.device) ?? one.device}: ${entryText(one)}</li>`)}
    </ol>
  </section>`;
}

function History({ short }) {
  const numbers = [...short.states.values()].filter((one) => typeof one.value === "number");
  const [chosen, setChosen] = useState(null);
  const [period, setPeriod] = useState(86_400);
  const [series, setSeries] = useState(null);
  const reading = chosen ?? numbers[0];
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!reading || !isOpen) return;
    const asked = { device: short.id, part: reading.part, capability: reading.capability, points: 300 };
    asked.since = { sec: Math.max(0, Math.floor(Date.now() / 1000 - period)), nanosec: 0 };
    call("/history/read", asked).then(setSeries, (error) => setSeries({ success: false, message: error.message, series: [] }));
  }, [short.id, reading?.part, reading?.capability, period, isOpen]);
  if (!reading) return null;
  const found = series?.series?.find((one) => one.times.length && one.values.length);
  return html`<section>
    <h3>History</h3>
    <p class="choices">
      <label
        >Value
        <select onChange=${(event) => setChosen(numbers[event.target.selectedIndex])}>
          ${numbers.map((one) => html`<option key=${`${one.part} ${one.capability}`}>${label(one.capability)}</option>`)}
        </select></label
      >
      ${PERIODS.map(([text, value]) => html`<button key=${value} type="button" aria-pressed=${value === period} onClick=${() => setPeriod(value)}>${text}</button>`)}
    </p>
    ${found
      ? html`<${Plot} label=${label(reading.capability)} times=${found.times} values=${[found.values]} names=${[label(reading.capability)]} />`
      : html`<p>${series ? series.message || "Nothing is kept of that time." : "…"}</p>`}
  </section>`;
}

function Facts({ device }) {
  const heard = Date.now() / 1000 - seconds(device.last_seen);
  return html`<section>
    <h3>What is known, and from where</h3>
    <table class="facts">
      <tbody>
        <tr><th scope="row">id</th><td>${device.id}</td><td></td></tr>
        <tr><th scope="row">heard</th><td>${durationText(Math.max(heard, 0))} ago</td><td>${device.freshness}</td></tr>
        ${device.facts.map(
          (fact, index) => html`<tr key=${index}>
            <th scope="row">${label(fact.name)}</th>
            <td>${fact.value}</td>
            <td>${fact.convention === "owner" ? `you, by the ${fact.key}` : [fact.gateway, fact.convention].filter(Boolean).join(", ")}</td>
          </tr>`,
        )}
        ${device.endpoints.map(
          (one) => html`<tr key=${`${one.gateway} ${one.key}`}>
            <th scope="row">reached by</th>
            <td>${one.gateway}: ${one.address}</td>
            <td>${one.command_address}</td>
          </tr>`,
        )}
        ${device.conflicts.map((text) => html`<tr key=${text}><th scope="row">conflict</th><td>${text}</td><td></td></tr>`)}
      </tbody>
    </table>
  </section>`;
}

function capabilityOf(full, reading) {
  const part = full?.parts.find((one) => one.id === reading.part);
  return part?.part.capabilities.find((one) => one.name === reading.capability);
}

const partName = (full, id) => full?.parts.find((one) => one.id === id)?.part.name || id;
