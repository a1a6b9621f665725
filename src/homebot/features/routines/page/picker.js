// Picks a sentence for a routine: what it is about, then one of those that homebot has for it, with its values.
import { useRef, useState } from "preact/hooks";
import { call } from "../../door.js";
import { deviceOf, rooms } from "../../house.js";
import { html } from "../../html.js";
import { language, say } from "../../language.js";
import { useOpen } from "../../opened.js";
import { titled } from "../../words.js";

const TEXT = "…"; // stands for what only a person knows
const boundsOf = (after) => (after.startsWith(" %") ? { min: 0, max: 100 } : {});
const typeOf = (value) => (value === TEXT ? "text" : value.includes(":") ? "time" : "number");

/** `kind` is that of the sentences: when, conditions or steps, `word` their name for people; `onPick` gets each that is added. */
export function Picker({ kind, word, onPick }) {
  const [{ device, sentences, chosen }, set] = useState({ device: "", sentences: null, chosen: "" }); // no device: times and the house
  const line = useRef(null);
  useOpen(async (isCurrent) => {
    const answer = await call("/routines/sentences", { device, language: language.value }).catch(() => ({}));
    if (isCurrent()) set({ device, sentences: answer[kind] ?? [], chosen: "" });
  }, [device, language.value]);
  const pieces = chosen.split(/[{}]/); // each second one is a value
  const add = () => {
    const values = [...line.current.querySelectorAll("input")];
    if (!values.every((one) => one.reportValidity())) return;
    onPick(pieces.map((piece, at) => (at % 2 ? values[(at - 1) / 2].value : piece)).join(""));
    set({ device, sentences, chosen: "" });
    line.current.previousElementSibling.querySelector("label:last-child select").focus(); // for the next one, as the button goes
  };
  const onKey = (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault(); // it would save the routine
    add();
  };
  const option = (id) => html`<option key=${id} value=${id}>${deviceOf(id).value.name}</option>`;
  return html`<div class="choices">
      <label><span>${say("device")}</span> <select value=${device} onChange=${(event) => set({ device: event.target.value, sentences: null, chosen: "" })}><option value="">${say("times and the house")}</option>${rooms.value.map(([room, ids]) => html`<optgroup key=${room} label=${room ? titled(room) : say("Without a room")}>${ids.map(option)}</optgroup>`)}</select></label>
      <label><span>${word}</span> <select value=${chosen} onChange=${(event) => set({ device, sentences, chosen: event.target.value })}><option value="">…</option>${sentences?.map((one) => html`<option key=${one} value=${one}>${one.replace(/[{}]/g, "")}</option>`)}</select></label>
    </div>
    ${sentences?.length === 0 && html`<p class="quiet">${say("There is nothing to propose.")}</p>`}
    ${chosen && html`<p key=${chosen} class="choices" ref=${line} onKeyDown=${onKey}>${pieces.map((piece, at) => (at % 2 ? html`<input type=${typeOf(piece)} ...${boundsOf(pieces[at + 1])} step="any" required style=${{ flex: "0 1 9rem" }} aria-label=${`${pieces[at - 1]}${TEXT}${pieces[at + 1]}`} defaultValue=${piece === TEXT ? "" : piece} />` : html`<span>${piece}</span>`))} <button type="button" onClick=${add}>${say("add")}</button></p>`}`;
}
