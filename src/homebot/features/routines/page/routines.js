// The routines: on or off, what they do, their last runs, and a form that writes their text.
import { useRef, useState } from "preact/hooks";
import { agree, tell } from "../../acts.js";
import { Added } from "../../added.js";
import { ask, call, may } from "../../door.js";
import { html } from "../../html.js";
import { say, sayReason } from "../../language.js";
import { Managing, Remove } from "../../managing.js";
import { useOpen } from "../../opened.js";
import { seconds, spoken, timeIn, timeText } from "../../words.js";
import { Gallery } from "./gallery.js";
import { Picker } from "./picker.js";

const AGAIN = 5000; // ms
const MODES = ["single", "restart", "queued", "parallel"];

export function Routines() {
  const [found, setFound] = useState(null);
  const [written, setWritten] = useState(null); // the routine in the form: null for none, {} for a new one
  const look = () => call("/routines/list", { check: true }).then(setFound, (error) => setFound({ routines: [], problem: error.message }));
  useOpen(() => look().then(() => AGAIN));
  const change = async (routine, what, more) => {
    const asked = { name: routine.name, change: what, ...more };
    let answer = await ask("/routines/change", { ...asked, unless_asks: true });
    if (answer.asks?.length) {
      const names = answer.asks.map(({ key, value }) => spoken(key) + (value && ` (${value})`)).join(", ");
      await new Promise((yes) => agree(what === "run" ? `${routine.name}: ${names}` : say("let this routine command {names}", { names }), yes));
      answer = await ask("/routines/change", asked);
    }
    if (answer.success || !more?.text) tell(sayReason(answer.message), answer.success); // the form tells its own mistakes
    look();
    return answer;
  };
  if (!found) return html`<p class="empty">${say("Asking homebot for its routines …")}</p>`;
  return html`
    ${found.problem && html`<p class="bad">${sayReason(found.problem)}</p>`}
    ${!found.routines.length && html`<p class="empty">${say("There is no routine yet.")}</p>`}
    <${Managing}>${!written && html`<p class="choices"><button type="button" onClick=${() => setWritten({})}>${say("new routine")}</button> <button type="button" onClick=${() => setWritten({ isReadyMade: true })}>${say("ready-made routines")}</button></p>`}<//>
    ${written?.isReadyMade && html`<${Gallery} onText=${(text) => setWritten({ draft: text })} onClose=${() => setWritten(null)} />`}
    ${written && !written.isReadyMade && html`<${Form} key=${written.name ?? ""} routine=${written} change=${change} onClose=${() => setWritten(null)} />`}
    <div class="columns">${found.routines.map((one) => html`<${Routine} key=${one.app} routine=${one} zone=${found.zone} change=${change} onEdit=${() => setWritten(one)} />`)}</div>
    <${Added} at="routines" zone=${found.zone} onChange=${look} Parts=${Parts} />`;
}

function Routine({ routine, zone, change, onEdit }) {
  const { name, notes, is_kept: isKept, proposed_by: by } = routine;
  return html`<section>
    <div class="title">
      <h2><bdi>${name}</bdi></h2>
      ${routine.is_running && html`<span class="mark">${say("running")}</span>`}
      ${by && html`<span class="mark">${say("proposed by {name}", { name: by })}</span>`}
      <button type="button" class="switch" role="switch" aria-checked=${String(routine.enabled && !routine.problem)} aria-label=${name} disabled=${!may("manage")} onClick=${() => change(routine, routine.enabled ? "disable" : "enable")}></button>
    </div>
    ${[routine.problem, ...routine.hints].filter(Boolean).map((text) => html`<p key=${text} class="bad">${sayReason(text)}</p>`)}
    ${may("manage") && isKept && routine.lacks.length > 0 && html`<p class="choices"><button type="button" onClick=${() => change(routine, "edit", { act: routine.lacks })}>${say("give it the right")}</button></p>`}
    <${Parts} of=${routine}>${routine.act.length > 0 && html`<div><dt>${say("may command")}</dt><dd>${routine.act.join(", ")}</dd></div>`}${seconds(routine.next) > 0 && html`<div><dt>${say("next")}</dt><dd>${timeIn(zone, routine.next)}</dd></div>`}<//>
    ${notes.length > 0 && html`<details><summary>${say("last runs")}: ${timeText(notes.at(-1).at)} ${sayReason(notes.at(-1).text)}</summary>
      <ol class="log">${[...notes].reverse().map((one, index) => html`<li class="own" key=${index}><time>${timeText(one.at)}</time><span>${sayReason(one.text)}</span></li>`)}</ol>
    </details>`}
    ${may("manage") && html`<p class="choices">
      <button type="button" onClick=${() => change(routine, "run")}>${say("run now")}</button>
      ${isKept && html`<button type="button" onClick=${onEdit}>${say("edit")}</button> <${Remove} name=${name} onRemove=${() => change(routine, "remove")} />`}
    </p>`}
  </section>`;
}

/** What starts a routine, its conditions and its steps. */
function Parts({ of: { when, conditions, steps }, children }) {
  const parts = [["when", when], ["if", conditions], ["do", steps]].filter(([, texts]) => texts.length);
  return html`<dl>
    ${parts.map(([word, texts]) => html`<div key=${word}><dt>${say(`${word}|routine`)}</dt><dd>${texts.map((text, index) => html`<div key=${index}>${text}</div>`)}</dd></div>`)}
    ${children}
  </dl>`;
}

const lines = (text) => text.split("\n").map((one) => one.trim()).filter(Boolean);

/** The list of a key in TOML; a line that is a table, such as a choice, is left as it is. */
const listOf = (key, text) => `${key} = [${lines(text).map((one) => (one.startsWith("{") ? one : JSON.stringify(one))).join(", ")}]\n`;

function textOf({ name, when, conditions, steps, mode }) {
  const more = (lines(conditions).length ? listOf("if", conditions) : "") + listOf("do", steps) + (mode === MODES[0] ? "" : `mode = "${mode}"\n`);
  return `[[routines]]\nname = ${JSON.stringify(name.trim())}\n${listOf("when", when)}${more}`;
}

/** Fields that write the text of a new routine; a known one is edited as text. */
function Form({ routine, change, onClose }) {
  const isNew = !routine.text;
  const [parts, setParts] = useState({ name: "", when: "", conditions: "", steps: "", mode: MODES[0] });
  const [text, setText] = useState(routine.text ?? routine.draft ?? "");
  const [problem, setProblem] = useState("");
  const area = useRef(null); // of the text
  const write = (key, value) => {
    const own = { ...parts, [key]: value };
    setParts(own);
    setText(textOf(own));
  };
  const submit = async (event) => {
    event.preventDefault();
    const { success, message } = await change(routine, isNew ? "new" : "edit", { text });
    if (success) return onClose();
    setProblem(message);
    area.current.focus();
    area.current.setSelectionRange(...placeIn(text, message));
  };
  const onInput = ({ target }) => write(target.name, target.value);
  const list = (key, word, title) => html`<div class="fields" role="group" aria-label=${say(`${word}|routine`)}>
    <label>${title} <textarea name=${key} rows="2" required=${word !== "if"} value=${parts[key]} onInput=${onInput}></textarea></label>
    <${Picker} kind=${key} word=${say(`${word}|routine`)} onPick=${(sentence) => write(key, [...lines(parts[key]), sentence].join("\n"))} />
  </div>`;
  return html`<form class="card fields" onSubmit=${submit}>
    ${isNew && !routine.draft && html`
      <label><span>${say("Name")}</span> <input name="name" required maxlength="100" value=${parts.name} onInput=${onInput} /></label>
      ${list("when", "when", say("when: what starts it, a line each"))}
      ${list("conditions", "if", say("if: what must hold then, all of it"))}
      ${list("steps", "do", say("do: its steps, a line each"))}
      <label>${say("if it starts while it runs")} <select name="mode" onChange=${onInput}>${MODES.map((one) => html`<option key=${one} value=${one}>${say(`${one}|mode`)}</option>`)}</select></label>`}
    <label>${say("the text")} <textarea ref=${area} class="code" rows="7" spellcheck="false" required value=${text} onInput=${(event) => setText(event.target.value)}></textarea></label>
    <p role="alert" class="bad">${sayReason(problem)}</p>
    <p class="buttons"><button>${say("save")}</button> <button type="button" onClick=${onClose}>${say("not now")}</button></p>
  </form>`;
}

/** Where in a text a mistake is, by its message: the item of a list, such as do.1; else a line; else its end. */
function placeIn(text, message) {
  const [, key, index = 0] = message.match(/\.(when|if|do|mode|name)(?:\.(\d+))?: /) ?? [];
  const from = key ? text.search(new RegExp(`^\\s*${key}\\s*=`, "m")) : -1;
  const found = from < 0 ? undefined : [...text.slice(from).matchAll(/"(?:[^"\\]|\\.)*"|'[^']*'|\{[^}]*\}/g)][index];
  if (found) return [from + found.index, from + found.index + found[0].length];
  const line = Number(message.match(/(?:\bline |^[^:]*:)(\d+)/)?.[1] ?? Infinity);
  const before = text.split("\n").slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  return [before, before + (text.split("\n")[line - 1]?.length ?? 0)];
}
