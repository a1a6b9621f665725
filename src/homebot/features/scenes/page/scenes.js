// The scenes: applied and undone with a button; with the right to it they are saved, edited and removed.
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { agree, tell } from "../../acts.js";
import { ask, call, connection, may, missing } from "../../door.js";
import { deviceOf, rooms } from "../../house.js";
import { html } from "../../html.js";
import { SIGNS, Sign, sceneSign } from "../../icons.js";
import { say } from "../../language.js";
import { Lacking, Remove } from "../../managing.js";
import { capital, spoken, titled } from "../../words.js";

const LONGEST = 300; // seconds until the last part has obeyed

const scenes = signal([]);

const load = () => call("/scenes/list").then((answer) => (scenes.value = answer.scenes), () => {});

async function apply(scene, more) {
  tell(`${scene.name}: …`, true);
  const { success, message, results = [], asks = [] } = await ask("/scenes/apply", { name: scene.id, ...more }, LONGEST);
  if (asks.length) {
    agree(`${say("undo {name}", { name: scene.name })}: ${asks.map((one) => `${spoken(one.key)} (${one.value})`).join(", ")}`, () => apply(scene, { undo: true, agreed: true }));
    return;
  }
  missing.value = results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
  tell(`${scene.name}: ${message || say(more.undo ? "undone" : "done")}`, success);
  load();
}

/** Change a scene; return whether that succeeded. */
async function change(name, what, more) {
  const { success, message, left_out: left = [] } = await ask("/scenes/change", { name, change: what, ...more });
  const texts = [message, ...left.map((one) => `${one.key}: ${one.value}`)].filter(Boolean);
  tell(`${name}: ${texts.join("; ") || say(what === "remove" ? "removed" : "saved")}`, success);
  load();
  return success;
}

/** The scenes of a room; without one, those of the owner. */
export function Scenes({ room }) {
  const [opened, setOpened] = useState(null); // the scene whose box is open, "new", or null
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (isOpen) load();
  }, [isOpen]);
  const isIn = (scene) => [scene.area, ...scene.parts.map((one) => one.area)].some((one) => one.toLowerCase() === room.toLowerCase());
  const shown = scenes.value.filter((one) => (room === undefined ? !one.is_native : isIn(one)));
  const open = (what) => () => setOpened(what === opened ? null : what);
  const close = () => setOpened(null);
  const start = (scene) => {
    const asking = scene.parts.filter((one) => one.asks).map((one) => `${spoken(one.name)} ${one.text} (${one.asks})`);
    if (asking.length) agree(`${scene.name}: ${asking.join(", ")}`, () => apply(scene, { agreed: true }));
    else apply(scene, {});
  };
  const scene = shown.find((one) => one.id === opened);
  return html`
    <div class="scenes" role="group" aria-label=${say("scenes")}>
      ${shown.map((one) => html`<span key=${one.id} class="scene">
        <button type="button" disabled=${!may("act")} onClick=${() => start(one)}><${Sign} path=${sceneSign(one.name)} size=${22} /> <bdi>${one.name}</bdi></button>
        ${one.can_undo && may("act") && html`<button type="button" aria-label=${say("undo {name}", { name: one.name })} onClick=${() => apply(one, { undo: true, unless_asks: true })}><${Sign} path=${SIGNS.undo} size=${20} /></button>`}
        <button type="button" aria-expanded=${one.id === opened} aria-label=${say("more of {name}", { name: one.name })} onClick=${open(one.id)}><${Sign} path=${SIGNS.more} size=${20} /></button>
      </span>`)}
      ${may("manage") && html`<button type="button" class="new" aria-expanded=${opened === "new"} onClick=${open("new")}><${Sign} path=${SIGNS.plus} size=${20} /> ${capital(say("new scene"))}</button>`}
    </div>
    ${shown.length > 0 && html`<${Lacking} right="act" />`}
    ${opened === "new" && html`<${NewScene} room=${room} onClose=${close} />`}
    ${scene && html`<${OneScene} key=${scene.id} scene=${scene} onClose=${close} />`}`;
}

/** A form for the name of a scene, and for the devices whose present values it has. */
function NewScene({ room, onClose }) {
  const submit = async (event) => {
    event.preventDefault();
    const given = new FormData(event.target);
    const values = given.getAll("device").map((key) => ({ key, value: "now" }));
    if (await change(given.get("name").trim(), "save", { values })) onClose();
  };
  const takes = (id) => deviceOf(id).value.settable.length && deviceOf(id).value.states.size;
  const found = rooms.value.map(([name, ids]) => [name, ids.filter(takes)]).filter(([, ids]) => ids.length);
  return html`<form class="card fields" aria-label=${say("new scene")} onSubmit=${submit}>
    <label><span>${say("Name")}</span> <input name="name" required maxlength="100" /></label>
    <p>${say("It keeps the present values of:")}</p>
    <div class="columns">${found.map(([name, ids]) => html`<details key=${name} open=${room !== undefined && name.toLowerCase() === room.toLowerCase()}>
      <summary>${name ? titled(name) : say("Without a room")}</summary>
      ${ids.map((id) => html`<label key=${id}><input type="checkbox" name="device" value=${id} /> <bdi>${deviceOf(id).value.name}</bdi></label>`)}
    </details>`)}</div>
    <p class="buttons"><button>${say("save")}</button> <button type="button" onClick=${onClose}>${say("not now")}</button></p>
  </form>`;
}

/** The values of a scene, in the words of `homebot do`; those of the owner can be changed. */
function OneScene({ scene, onClose }) {
  const { name, parts, problems } = scene;
  const mayChange = may("manage") && !scene.is_native && !scene.is_configured;
  const keyOf = (one) => (one.part ? `${one.device}#${one.part}` : one.device);
  const submit = async (event) => {
    event.preventDefault();
    const given = new FormData(event.target);
    const values = parts.map((one, at) => ({ key: keyOf(one), value: given.get(`value${at}`).trim() })).filter(({ value }, at) => value !== parts[at].text);
    if (values.length && !(await change(name, "edit", { values }))) return;
    const target = given.get("name").trim();
    if (target === name || (await change(name, "rename", { target }))) onClose();
  };
  return html`<form class="card fields" aria-label=${name} onSubmit=${submit}>
    <h3><bdi>${name}</bdi></h3>
    ${mayChange && html`<label><span>${say("Name")}</span> <input name="name" required maxlength="100" defaultValue=${name} /></label>`}
    ${parts.map((one, at) => html`<label key=${keyOf(one)}><span><bdi>${spoken(one.name)}</bdi></span> ${mayChange ? html`<input name=${`value${at}`} defaultValue=${one.text} />` : one.text} ${one.asks && html`<small>${one.asks}</small>`}</label>`)}
    ${problems.map((one) => html`<p key=${one.key} class="bad">${one.key}: ${one.value}</p>`)}
    ${!parts.length && html`<p class="quiet">${say("What keeps this scene does not tell its values.")}</p>`}
    ${mayChange && html`<p class="quiet">${say("A device without a value is left out.")}</p>`}
    ${!scene.is_native && !scene.is_configured && html`<${Lacking} right="manage" />`}
    <p class="buttons">
      ${mayChange && html`<button>${say("save")}</button>
        <button type="button" onClick=${() => change(name, "save").then(onClose)}>${say("take the present values")}</button>
        <${Remove} name=${name} onRemove=${() => change(name, "remove").then(onClose)} />`}
      <button type="button" onClick=${onClose}>${say("close|do")}</button>
    </p>
  </form>`;
}
