// The people of the home: by their phones, and by trackers that homebot knows.
import { useState } from "preact/hooks";
import { shown } from "../house.js";
import { html, written } from "../html.js";
import { say } from "../language.js";
import { Remove } from "../managing.js";
import { change, textOf, useTable } from "../setting.js";

export function People() {
  const people = useTable("people");
  const [changed, setChanged] = useState("");
  const [isAdding, setIsAdding] = useState(0); // another number is an empty form
  if (!people) return html`<p class="empty">${say("Asking homebot how it is …")}</p>`;
  const trackers = shown.value.filter((device) => device.type === "x_tracker").map((device) => device.name);
  const { trackers: own = [], ping = "" } = people[changed] ?? {};
  const save = async (event) => {
    const given = written(event);
    const found = { trackers: given.getAll("trackers"), ping: given.get("ping").trim() };
    const [filled, empty] = [true, false].map((isFilled) => Object.keys(found).filter((key) => found[key].length > 0 === isFilled));
    const values = Object.fromEntries(filled.map((key) => [key, textOf(found[key])]));
    if (!(await change(["people", changed || given.get("name").trim()], values, { remove: empty }))) return;
    setChanged("");
    setIsAdding(isAdding + 1);
  };
  return html`<p>${say("homebot knows who is at home by phones in the network, and by trackers.")}</p>
    ${Object.entries(people).map(([name, one]) => html`<div key=${name} class="box"><p><strong><bdi>${name}</bdi></strong> ${[...(one.trackers ?? []), one.ping].filter(Boolean).join(", ")}</p>
      <p class="choices"><button type="button" onClick=${() => setChanged(name)}>${say("change|do")}</button> <${Remove} name=${name} onRemove=${() => change(["people"], {}, { remove: [name] })} /></p></div>`)}
    <form key=${`${changed} ${isAdding}`} class="fields" aria-label=${say("Person")} onSubmit=${save}>
      ${changed ? html`<h3>${changed}</h3>` : html`<label><span>${say("Name")}</span> <input name="name" required maxlength="100" /></label>`}
      <label><span>${say("Phone in the network")}</span> <input name="ping" autocomplete="off" placeholder="192.168.1.23" maxlength="253" pattern="[A-Za-z0-9:._%\\-]*" defaultValue=${ping} /></label>
      ${[...new Set([...own, ...trackers])].map((name) => html`<label key=${name} class="check"><input type="checkbox" name="trackers" value=${name} defaultChecked=${own.includes(name)} /> <bdi>${name}</bdi></label>`)}
      <p class="buttons"><button>${changed ? say("save") : say("add")}</button> ${changed && html`<button type="button" onClick=${() => setChanged("")}>${say("not now")}</button>`}</p>
    </form>`;
}
