// A keypad for a code, only where a device takes one; the code is used once and kept nowhere.
import { useEffect, useState } from "preact/hooks";
import { html } from "./html.js";
import { SIGNS, Sign } from "./icons.js";
import { say } from "./language.js";
import { HoldButton } from "./touch.js";

const DIGITS = ["1", "2", "3", "4", "5", "6", "7", "8", "9"];

/** The `kind` is digits or text. What lets in is held at the end, as everywhere. */
export function Keypad({ text, kind, isHeld, onDone, onCancel }) {
  const [code, setCode] = useState("");
  const done = () => {
    onDone(code);
    setCode("");
  };
  const press = (digit) => () => setCode((old) => old + digit);
  const back = () => setCode((old) => old.slice(0, -1));
  useEffect(() => {
    const onKey = ({ key, target, ctrlKey, metaKey, altKey }) => {
      if (ctrlKey || metaKey || altKey || target.matches?.("input, textarea, select")) return;
      if (/^\d$/.test(key)) press(key)();
      else if (key === "Backspace") back();
    };
    if (kind === "digits") addEventListener("keydown", onKey);
    return () => removeEventListener("keydown", onKey);
  }, [kind]);
  return html`<div class="keypad" role="group" aria-label=${say("code for {what}", { what: text })}>
    <p>${say("code for {what}", { what: text })} ${kind === "digits" && html`<b role="status" aria-label=${say("{count} digits", { count: code.length })}>${"●".repeat(code.length) || "–"}</b>`}</p>
    ${kind === "text"
      ? html`<input class="wide" name="code" type="password" autocomplete="one-time-code" maxlength="255" aria-label=${say("code for {what}", { what: text })} value=${code} onInput=${(event) => setCode(event.target.value)} />`
      : html`${DIGITS.map((digit) => html`<button key=${digit} type="button" onClick=${press(digit)}>${digit}</button>`)}
        <button type="button" aria-label=${say("cancel")} onClick=${onCancel}><${Sign} path=${SIGNS.close} size=${26} /></button>
        <button type="button" onClick=${press("0")}>0</button>
        <button type="button" aria-label=${say("delete")} onClick=${back}><${Sign} path=${SIGNS.backspace} size=${26} /></button>`}
    ${isHeld ? html`<${HoldButton} name="wide" text=${text} onHeld=${done} />` : html`<button type="button" class="wide chief" onClick=${done}>${text}</button>`}
  </div>`;
}
