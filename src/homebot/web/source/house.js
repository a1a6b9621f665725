// The devices of the house, live: one signal a device, so that a change renders one row.
import { batch, computed, effect, signal } from "@preact/signals";
import { now } from "./clock.js";
import { call, connection, heardAt, onOpen, subscribe } from "./door.js";
import { askUsage, beginVisit, isKept } from "./layout.js";
import { spoken } from "./words.js";

const SLICE = 200; // devices in one answer
const GATHER = 200; // ms for which changed devices are gathered before they are asked for

const devices = new Map(); // by id: a signal of the device
const ids = signal([]); // sorted by room and name
export const count = computed(() => ids.value.length);
export const isLoaded = signal(false);

/** The rooms with the ids of their devices; those without a room last. */
export const rooms = computed(() => {
  const found = new Map(); // by the name without case, as makers write a room differently
  for (const id of ids.value) {
    const room = devices.get(id)?.peek().room ?? "";
    const key = room.toLowerCase();
    if (!found.has(key)) found.set(key, [room, []]);
    found.get(key)[1].push(id);
  }
  const last = (name) => (name === "" ? 1 : 0);
  return [...found.values()].sort(([a], [b]) => last(a) - last(b) || a.localeCompare(b));
});

/** The signal of a device; undefined until it comes, which the reader is told. */
export const deviceOf = (id) => devices.get(id) ?? void ids.value;

/** Whether the owner hides a device in the house and on the plan. */
export const isHidden = (id) => isKept("hidden", id);

/** The floors of rooms that have one, by the rooms' names in lower case. */
export const floors = signal(new Map());

/** The reading of a device that has a value; undefined without one. */
export const readingOf = (device, capability) => [...device.states.values()].find((reading) => reading.capability === capability && reading.value !== null);
export const read = (device, capability) => readingOf(device, capability)?.value;
export const takes = (device, capability) => device.settable.includes(capability);

/** All devices that are not hidden, in the order of rooms and names. */
export const shown = computed(() => rooms.value.flatMap(([, found]) => found.filter((id) => !isHidden(id))).map((id) => devices.get(id).value));

export const nameOf = (id) => devices.get(id)?.value.name ?? id;

const LAST = "homebot.house";

/** Keep the house for this tab, as it may be loaded anew while homebot is away. */
function keepHouse() {
  if (!isLoaded.value) return;
  const found = [...devices.values()].map((one) => ({ ...one.value, name: one.value.given, states: [...one.value.states.values()] }));
  try {
    sessionStorage.setItem(LAST, JSON.stringify({ at: connection.value.state === "open" ? now() : heardAt.value, home: connection.value.home, found }));
  } catch {
    sessionStorage.removeItem(LAST); // the house is larger than what a tab may keep
  }
}

/** Show the house that this tab knew last. */
function takeHouse() {
  const kept = sessionStorage.getItem(LAST);
  if (!kept) return;
  const { at, home, found } = JSON.parse(kept);
  batch(() => {
    for (const device of found) put(device, -1);
    sortIds();
    heardAt.value = at;
    connection.value = { ...connection.value, home };
    isLoaded.value = true;
  });
}

export function follow() {
  addEventListener("pagehide", keepHouse);
  effect(() => {
    const { state, reason } = connection.value;
    if (state === "connecting" && reason && !isLoaded.peek()) takeHouse();
    if (state === "refused") sessionStorage.removeItem(LAST);
  });
  subscribe("/discovery/states", (change) => later(() => applyValues(change)));
  subscribe("/discovery/changes", (change) => later(() => applyDevice(change)));
  onOpen(load);
}

let pending = [];
const wanted = new Set();
let asking = 0;

function later(work) {
  pending.push(work);
  if (pending.length === 1) requestAnimationFrame(applyPending);
}

function applyPending() {
  const work = pending;
  pending = [];
  batch(() => {
    for (const one of work) one();
  });
}

async function load() {
  const order = askUsage().then(() => isLoaded.peek() || beginVisit());
  call("/discovery/places").then((answer) => (floors.value = new Map(answer.rooms.filter((one) => one.floor).map((one) => [one.name.toLowerCase(), one.floor]))), () => {});
  const slice = (offset) => call("/discovery/list", { offset, limit: SLICE });
  const seen = new Set();
  try {
    const first = await slice(0);
    const others = Array.from({ length: Math.ceil(first.total / SLICE) - 1 }, (_, at) => slice(SLICE * (at + 1)));
    const answers = [first, ...(await Promise.all(others))];
    batch(() => {
      for (const { devices: found, sequence } of answers) for (const device of found) put(device, sequence);
      sortIds();
    });
    for (const { devices: found } of answers) for (const device of found) seen.add(device.id);
  } catch {
    return; // the next connection loads them
  }
  await order; // nothing moves later
  batch(() => {
    for (const id of devices.keys()) if (!seen.has(id)) devices.delete(id);
    sortIds();
    isLoaded.value = true;
  });
}

function put(device, sequence) {
  const states = new Map(device.states.map((one) => [key(one), one]));
  const known = devices.get(device.id);
  if (known && known.peek().sequence > sequence) return;
  const now = { ...device, given: device.name, name: spoken(device.name), states, sequence, changedAt: known?.peek().changedAt ?? 0 };
  if (known) known.value = now;
  else devices.set(device.id, signal(now));
}

function applyValues(change) {
  const known = devices.get(change.device);
  if (!known) {
    ask(change.device);
    return;
  }
  const device = known.peek();
  if (change.sequence <= device.sequence) return;
  const states = new Map(device.states);
  for (const reading of change.readings) {
    if (states.has(key(reading))) states.set(key(reading), { ...reading, since: change.told_at });
    else ask(change.device);
  }
  known.value = { ...device, states, sequence: change.sequence, changedAt: Date.now() };
}

function applyDevice(change) {
  const { id } = change.device;
  if (change.kind === "removed") {
    devices.delete(id);
    sortIds();
  } else {
    ask(id);
  }
  if (change.other) ask(change.other);
}

function ask(id) {
  wanted.add(id);
  asking ||= setTimeout(askNow, GATHER);
}

async function askNow() {
  asking = 0;
  const asked = [...wanted].slice(0, SLICE);
  for (const id of asked) wanted.delete(id);
  if (wanted.size) asking = setTimeout(askNow, GATHER);
  try {
    const answer = await call("/discovery/list", { ids: asked });
    batch(() => {
      const found = new Set(answer.devices.map((device) => device.id));
      for (const id of asked) if (!found.has(id)) devices.delete(id);
      for (const device of answer.devices) put(device, answer.sequence);
      sortIds();
    });
  } catch {
    // the next connection loads them
  }
}

function sortIds() {
  const order = [...devices].map(([id, one]) => [one.peek().room, one.peek().name, id]);
  order.sort((a, b) => compare(a[0], b[0]) || compare(a[1], b[1]) || compare(a[2], b[2]));
  ids.value = order.map((one) => one[2]);
}

const { compare } = new Intl.Collator(); // ten times as fast as localeCompare

const key = (reading) => `${reading.part} ${reading.capability}`;
