// The gallery of ready-made routines: one is chosen, asks for its devices and values, and gives a text to save.
import { useEffect, useState } from "preact/hooks";
import { ask, call } from "../../door.js";
import { html, written } from "../../html.js";
import { language, say, sayReason } from "../../language.js";
import { useOpen } from "../../opened.js";
import { capital, spoken } from "../../words.js";

/** `onText` gets the text of the chosen one. */
export function Gallery({ onText, onClose }) {
  const [routines, setRoutines] = useState([]);
  const [chosen, setChosen] = useState(null);
  useOpen(() => void call("/routines/gallery", { language: language.value }).then((answer) => setRoutines(answer.routines), () => {}));
  return html`<section class="card fields" aria-labelledby="gallery"><h2 id="gallery">${say("Ready-made routines")}</h2>
    ${chosen ? html`<${Inputs} routine=${chosen} onText=${onText} onBack=${() => setChosen(null)} />` : html`<div class="list">${routines.map((one) => html`<button key=${one.name} type="button" name=${one.name} onClick=${() => setChosen(one)}>${one.about}</button>`)}</div>`}
    <p class="buttons"><button type="button" onClick=${onClose}>${say("not now")}</button></p>
  </section>`;
}

function Inputs({ routine, onText, onBack }) {
  const [fits, setFits] = useState({}); // by key: the names of devices
  const [problem, setProblem] = useState("");
  useEffect(() => {
    for (const { key, find } of routine.inputs.filter((one) => one.find))
      call("/discovery/find_devices", { query: find }).then(({ devices }) => setFits((old) => ({ ...old, [key]: devices.map((one) => one.name) })), () => setFits((old) => ({ ...old, [key]: [] })));
  }, [routine.name]);
  const submit = async (event) => {
    const inputs = [...written(event)].map(([key, value]) => ({ key, value }));
    const { success, message, text } = await ask("/routines/gallery", { name: routine.name, inputs, language: language.value });
    if (success) onText(text);
    else setProblem(sayReason(message));
  };
  const missing = routine.inputs.find(({ key, find }) => find && fits[key]?.length === 0);
  return html`<form class="fields" onSubmit=${submit}><p>${routine.about}</p>
    ${routine.inputs.map(({ key, label, find, default: usual }) => html`<label key=${key}><span>${capital(label)}</span>
      ${find ? html`<select name=${key} required>${(fits[key] ?? []).map((name) => html`<option key=${name} value=${`'${name}'`}>${spoken(name)}</option>`)}</select>` : html`<input name=${key} required defaultValue=${usual} />`}</label>`)}
    <p role="alert" class="bad">${problem || (missing && say("No device of this house fits: {what}", { what: missing.label }))}</p>
    <p class="buttons"><button disabled=${Boolean(missing)}>${say("next step")}</button> <button type="button" onClick=${onBack}>${say("back")}</button></p>
  </form>`;
}
