// The forms of a scene: a new one, and the values of one that there is.
import { tell } from "../../acts.js";
import { ask, may } from "../../door.js";
import { deviceOf, rooms } from "../../house.js";
import { html, written } from "../../html.js";
import { say, sayReason } from "../../language.js";
import { Lacking, Remove } from "../../managing.js";
import { spoken, titled } from "../../words.js";
import { load } from "./scenes.js";

/** Change a scene; return whether that succeeded. */
async function change(name, what, more) {
  const { success, message, left_out: left = [] } = await ask("/scenes/change", { name, change: what, ...more });
  const texts = [message, ...left.map((one) => `${one.key}: ${one.value}`)].filter(Boolean).map(sayReason);
  tell(`${name}: ${texts.join("; ") || say(what === "remove" ? "removed" : "saved")}`, success);
  load();
  return success;
}

/** A form for the name of a scene, and for the devices whose present values it has. */
export function NewScene({ room, onClose }) {
  const submit = async (event) => {
    const given = written(event);
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
export function OneScene({ scene, onClose }) {
  const { name, parts, problems } = scene;
  const mayChange = may("manage") && !scene.is_native && !scene.is_configured;
  const keyOf = (one) => (one.part ? `${one.device}#${one.part}` : one.device);
  const submit = async (event) => {
    const given = written(event);
    const values = parts.map((one, at) => ({ key: keyOf(one), value: given.get(`value${at}`).trim() })).filter(({ value }, at) => value !== parts[at].text);
    if (values.length && !(await change(name, "edit", { values }))) return;
    const target = given.get("name").trim();
    if (target === name || (await change(name, "rename", { target }))) onClose();
  };
  return html`<form class="card fields" aria-label=${name} onSubmit=${submit}>
    <h3><bdi>${name}</bdi></h3>
    ${mayChange && html`<label><span>${say("Name")}</span> <input name="name" required maxlength="100" defaultValue=${name} /></label>`}
    ${parts.map((one, at) => html`<label key=${keyOf(one)}><span><bdi>${spoken(one.name)}</bdi></span> ${mayChange ? html`<input name=${`value${at}`} defaultValue=${one.text} />` : one.text} ${one.asks && html`<small>${one.asks}</small>`}</label>`)}
    ${problems.map((one) => html`<p key=${one.key} class="bad">${one.key}: ${sayReason(one.value)}</p>`)}
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
