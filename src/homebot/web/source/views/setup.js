// The setup of a new home in steps, and what System leads to later.
import { useEffect, useState } from "preact/hooks";
import { Added } from "../added.js";
import { ask, call, connection, makeToken, onOpen } from "../door.js";
import { count, rooms, shown } from "../house.js";
import { html, written } from "../html.js";
import { LANGUAGES, choose, language, say, sayReason } from "../language.js";
import { Managing } from "../managing.js";
import { Unpaired } from "../pairing.js";
import { Restart, Told, change, textOf, told } from "../setting.js";
import { Backup } from "./backup.js";
import { People } from "./people.js";

const STEPS = { language: "Language", home: "Name and place", devices: "Devices", rooms: "Rooms", screens: "Screens" };
/** What a home has no need of on its first day. */
const OTHERS = { people: "People", alerts: "Alerts", backup: "Backup" };
const MOST_ROOMS = 60; // devices that are asked for at once

/** By gateway: its name for people, and its keys with an example, whose values are texts; `password` and `token` are kept in files of their own. */
const NAMES = { mqtt: "MQTT", homeassistant: "Home Assistant", hue: "Philips Hue", homekit: "HomeKit", matter: "Matter", mdns: "mDNS", ble: "Bluetooth", coap: "CoAP" };
const GATEWAYS = {
  mqtt: { url: "192.168.1.10", user: "", password: "" },
  homeassistant: { url: "192.168.1.20:8123", token: "" },
  hue: {}, homekit: {}, matter: {}, mdns: {}, ble: {}, coap: {},
};
/** What a gateway needs of its owner, beside its address. */
const NEEDS = { homeassistant: "Token", homekit: "The code on the device", matter: "The code on the device", hue: "A press of its button" };
const SCHEMES = { homeassistant: "http" }; // of addresses that are typed without one; else the name of the gateway
const LABELS = { url: "Address", user: "User", password: "Password", token: "Token" };
const SECRET = ["password", "token"];
const WORDS = ["Kitchen", "Living room", "Bedroom", "Bathroom", "Hall", "Study", "Garden", "Garage", "Cellar", "Terrace"];

const named = (name) => NAMES[name] ?? name;

export function Setup({ id }) {
  const step = id in STEPS || id in OTHERS ? id : "language";
  const names = Object.keys(STEPS);
  const next = names[names.indexOf(step) + 1];
  const Step = PARTS[step];
  useEffect(() => { told.value = null; }, [step]);
  return html`
    ${step in STEPS && html`<ol class="steps" aria-label=${say("Setup")}>${names.map((name, at) => html`<li key=${name}><a href=${`#/setup/${name}`} aria-current=${name === step ? "step" : undefined}><b>${at + 1}</b> <span>${say(STEPS[name])}</span></a></li>`)}</ol>`}
    <section class="card fields"><h2>${say(STEPS[step] ?? OTHERS[step])}</h2>
      <${Managing}><${Step} /><${Told} canRestart=${step !== "devices"} /><//>
      <p class="choices">${step in OTHERS ? html`<a href="#/system">${say("System")}</a>` : html`<a class="chief" href=${next ? `#/setup/${next}` : "#/home"}>${say(next ? "next step" : "to the house")}</a>`}</p>
    </section>`;
}

const Language = () => html`<p class="choices">${Object.entries(LANGUAGES).map(([name, text]) => html`<button key=${name} type="button" lang=${name} aria-pressed=${name === language.value} onClick=${() => choose(name)}>${text}</button>`)}</p>`;

function Place() {
  const [here, setHere] = useState(null);
  const save = async (event) => {
    const given = Object.fromEntries(written(event));
    const values = { name: textOf(given.name.trim()), zone: textOf(given.zone.trim()) };
    for (const key of ["latitude", "longitude"]) if (given[key]) values[key] = Number(given[key]).toFixed(3);
    await change(["home"], values);
  };
  const look = () => navigator.geolocation.getCurrentPosition(({ coords }) => setHere(coords), (error) => (told.value = { success: false, message: error.message }));
  return html`<form class="fields" onSubmit=${save}>
    <label><span>${say("Name")}</span> <input name="name" required maxlength="60" defaultValue=${connection.value.home} /></label>
    <label><span>${say("Time zone")}</span> <input name="zone" required defaultValue=${Intl.DateTimeFormat().resolvedOptions().timeZone} /></label>
    <label><span>${say("Latitude")}</span> <input name="latitude" type="number" step="any" min="-90" max="90" value=${here?.latitude} /></label>
    <label><span>${say("Longitude")}</span> <input name="longitude" type="number" step="any" min="-180" max="180" value=${here?.longitude} /></label>
    <p class="quiet">${say("The place gives sunrise and sunset; it stays here.")}</p>
    <p class="buttons"><button>${say("save")}</button> ${isSecureContext && navigator.geolocation && html`<button type="button" onClick=${look}>${say("where this screen is")}</button>`}</p>
  </form>`;
}

function Devices() {
  const [found, setFound] = useState(null);
  const [added, setAdded] = useState("");
  const look = () => call("/setup/found").then(setFound, () => {});
  useEffect(() => onOpen(look), []);
  if (!found) return html`<p class="empty">${say("Asking homebot how it is …")}</p>`;
  const act = async (name, isOn) => { if (await change(["gateways", name], { act: String(isOn) })) look(); };
  const onAdded = () => { setAdded(""); look(); };
  const others = Object.keys(GATEWAYS).filter((name) => !found.gateways.includes(name));
  return html`
    <p>${say(count.value === 1 ? "{count} device" : "{count} devices", { count: count.value })}</p>
    ${found.unused.map((one) => html`<section key=${one.gateway + one.url} class="box">
      <h3>${named(one.gateway)}${one.url && ` · ${one.url}`}</h3>
      <p>${one.names.join(", ") || say("A server on this computer")}</p>${NEEDS[one.gateway] && html`<p class="quiet">${say("It needs: {what}", { what: say(NEEDS[one.gateway]) })}</p>`}
      ${added === one.gateway ? html`<${Gateway} name=${one.gateway} url=${one.url} onAdded=${onAdded} />` : html`<p class="choices"><button type="button" onClick=${() => setAdded(one.gateway)}>${say("use {name}", { name: named(one.gateway) })}</button></p>`}
    </section>`)}
    ${found.unpaired.map((one) => html`<${Unpaired} key=${one.gateway + one.unpaired.device} ...${one} />`)}
    ${found.gateways.map((name) => html`<label key=${name} class="check"><input type="checkbox" name=${`act-${name}`} checked=${found.acting.includes(name)} onChange=${(event) => act(name, event.target.checked)} /> ${say("{name} may command devices", { name: named(name) })}</label>`)}
    <label><span>${say("Add")}</span> <select name="gateway" value=${added} onChange=${(event) => setAdded(event.target.value)}><option value="">…</option>${others.map((name) => html`<option key=${name} value=${name}>${named(name)}</option>`)}</select></label>
    ${added && !found.unused.some((one) => one.gateway === added) && html`<${Gateway} key=${added} name=${added} onAdded=${onAdded} />`}
    <p class="quiet">${say("New gateways begin with the next start of homebot.")}</p>
    ${found.can_restart && html`<p class="choices"><${Restart} /></p>`}`;
}

/** The form of a gateway that is not used yet. */
function Gateway({ name, url = "", onAdded }) {
  const keys = Object.entries(GATEWAYS[name] ?? {});
  const save = async (event) => {
    const given = written(event);
    const filled = keys.map(([key]) => [key, given.get(key).trim()]).filter(([, value]) => value);
    const values = filled.filter(([key]) => !SECRET.includes(key)).map(([key, value]) => [key, textOf(key === "url" && !value.includes("://") ? `${SCHEMES[name] ?? name}://${value}` : value)]);
    const secrets = filled.filter(([key]) => SECRET.includes(key));
    if (await change(["gateways", name], { ...Object.fromEntries(values), act: String(given.get("act") === "on") }, { secrets: Object.fromEntries(secrets) })) onAdded();
  };
  return html`<form class="fields" aria-label=${name} onSubmit=${save}>
    ${keys.map(([key, example]) => html`<label key=${key}><span>${say(LABELS[key])}</span> <input name=${key} type=${SECRET.includes(key) ? "password" : "text"} autocomplete="off" placeholder=${example} defaultValue=${key === "url" ? url : ""} required=${key === "url"} /></label>`)}
    <label class="check"><input type="checkbox" name="act" /> ${say("{name} may command devices", { name: named(name) })}</label>
    <p class="buttons"><button>${say("use {name}", { name: named(name) })}</button></p>
  </form>`;
}

/** The room that the name of a device speaks of: one that is there, or a usual one. */
function guess(name, known) {
  const text = name.toLowerCase();
  const words = WORDS.flatMap((word) => [[say(word), say(word)], [word.split(" ")[0], say(word)]]);
  return [...known.map((room) => [room, room]), ...words].find(([word]) => text.includes(word.toLowerCase()))?.[1] ?? "";
}

function Rooms() {
  const known = rooms.value.map(([name]) => name).filter(Boolean);
  const without = shown.value.filter((device) => !device.room).slice(0, MOST_ROOMS);
  const save = async (event) => {
    const given = [...written(event)].filter(([, room]) => room.trim());
    const problems = [];
    for (const [device, room] of given) {
      const { message } = await ask("/discovery/place", { device, room: room.trim(), is_new: true });
      if (message) problems.push(sayReason(message));
    }
    told.value = { success: !problems.length, message: problems.join("; ") || say("saved"), lines: [], isPending: true };
  };
  if (!without.length) return html`<p>${say(count.value ? "Every device has a room." : "No device is there yet.")}</p>`;
  return html`<form class="fields" onSubmit=${save}>
    <datalist id="known-rooms">${[...new Set([...known, ...WORDS.map((word) => say(word))])].map((name) => html`<option key=${name} value=${name} />`)}</datalist>
    ${without.map((device) => html`<label key=${device.id}><span>${device.name}</span> <input name=${device.id} list="known-rooms" maxlength="200" defaultValue=${guess(device.name, known)} /></label>`)}
    <p class="buttons"><button>${say("save")}</button></p>
  </form>`;
}

const RIGHTS = { look: ["read"], act: ["read", "act: all"], manage: ["read", "act: all", "manage"] };
const RIGHT_TEXTS = { look: "look", act: "look and act", manage: "everything" };

function Screens() {
  const [made, setMade] = useState("");
  const make = async (event) => {
    const given = written(event);
    const answer = await makeToken(given.get("name").trim(), RIGHTS[given.get("may")]);
    told.value = answer.success ? null : answer;
    setMade(answer.token ? `${location.origin}/#token=${answer.token}` : "");
  };
  return html`<p>${say("Each screen has a token of its own, which can be taken away.")}</p>
    <form class="fields" onSubmit=${make}>
      <label><span>${say("Name")}</span> <input name="name" required pattern="[A-Za-z0-9_\\-]+" /></label>
      <label><span>${say("It may")}</span> <select name="may">${Object.entries(RIGHT_TEXTS).map(([name, text]) => html`<option key=${name} value=${name} selected=${name === "act"}>${say(text)}</option>`)}</select></label>
      <p class="buttons"><button>${say("make a token")}</button></p>
    </form>
    ${made && html`<div class="box"><p>${say("Open this once on the screen; it is shown only now:")}</p><pre>${made}</pre></div>`}`;
}

/** What each step shows. */
const PARTS = {
  language: Language,
  home: Place,
  devices: Devices,
  rooms: Rooms,
  screens: Screens,
  people: People,
  alerts: () => html`<${Added} at="addresses" />`,
  backup: Backup,
};
