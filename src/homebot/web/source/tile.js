// A tile: icon, name, state in words; a tap does the main act, a slide sets the level, a hold or the arrow opens the sheet.
import { Component } from "preact";
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { codeOf, isGuarded, pending, perform } from "./acts.js";
import { deviceOf } from "./house.js";
import { html } from "./html.js";
import { SIGNS, Sign } from "./icons.js";
import { kindOf, signOf, stateOf, toneOf } from "./kinds.js";
import { say } from "./language.js";
import { Stepper, stepped } from "./stepper.js";
import { HoldButton, useTouch } from "./touch.js";
import { label, titled, unitOf, valueText } from "./words.js";

const GIVES_UP = 6000; // ms after which a tile asks no more

/** The id of the device whose sheet is open; empty for none. */
export const sheet = signal("");

/** What had the focus before the sheet. */
let opener = null;
export const giveFocusBack = () => opener?.focus();

/** Open the sheet of a device; the way back of the browser closes it. */
export function openSheet(id) {
  opener = document.activeElement;
  history.pushState({ sheet: id }, "");
  sheet.value = id;
}

export const closeSheet = () => (history.state?.sheet ? history.back() : (sheet.value = ""));

addEventListener("popstate", (event) => (sheet.value = event.state?.sheet ?? ""));

/** A tile is rendered again by its own signal alone, never by the list. */
export class Tile extends Component {
  shouldComponentUpdate(next) {
    return next.room !== this.props.room;
  }

  render({ id, room = "" }) {
    return html`<${Face} id=${id} room=${room} />`;
  }
}

function Face({ id, room }) {
  const device = deviceOf(id)?.value;
  const [moved, setMoved] = useState(null);
  const [asks, setAsks] = useState("");
  useEffect(() => {
    if (!asks) return undefined;
    const timer = setTimeout(() => setAsks(""), GIVES_UP);
    return () => clearTimeout(timer);
  }, [asks]);
  const kind = device && kindOf(device);
  const act = (device?.may_act && kind.act?.(device)) || null;
  const level = device?.may_act ? (kind.level?.(device) ?? null) : null;
  const open = () => openSheet(id);
  const set = (value) => {
    setMoved(null);
    perform(device, kind.slide(value));
  };
  const tap = (event) => (!act || codeOf(device, act) ? open() : isGuarded(device, act) ? setAsks(event.detail ? "touch" : "key") : perform(device, act));
  const touch = useTouch({ onTap: tap, onHold: open, ...(level === null ? {} : { onSlide: setMoved, onSlid: set }) });
  if (!device) return null;
  const state = moved === null ? stateOf(device) : `${moved}\u00a0%`;
  const waits = pending.value.get(id);
  const reading = device.may_act && !waits ? stepped(device) : undefined;
  const hasSteps = reading && kind.group === "climate";
  const notes = [reading && say("set to {value}", { value: valueText(reading.capability, reading.value, unitOf({ name: reading.capability })) }), device.waits && say("not approved"), !device.may_act && kind.act?.(device) && say("only to look at")].filter(Boolean);
  const name = room ? `${titled(room)}: ${device.name}` : device.name;
  const verb = act && say(`${act.text}|do`);
  const isSwitch = act && kind.isSwitch;
  return html`<div class=${`tile ${toneOf(device)} ${moved === null ? "" : "moving"} ${hasSteps ? "stepping" : ""}`}>
    ${level !== null && html`<span class="level" style=${{ inlineSize: `${moved ?? level}%` }}></span>`}
    <button type="button" class="main" role=${isSwitch ? "switch" : undefined} aria-checked=${isSwitch ? String(kind.isActive(device)) : undefined} aria-label=${`${name}, ${state}${verb && !isSwitch ? `, ${verb}` : ""}`} ...${touch}></button>
    <span class="icon"><${Sign} path=${signOf(device)} size=${26} /></span>
    <span class="name"><bdi>${device.name}</bdi></span>
    <span class="state">${waits ? `… ${waits}` : html`${state}${notes.map((text, at) => html`<small>${at || state ? " · " : ""}${text}</small>`)}`}${room && html`<small class="where"> · ${titled(room)}</small>`}</span>
    ${hasSteps ? html`<${Stepper} device=${device} reading=${reading} />` : html`<button type="button" class="more" aria-label=${say("more of {name}", { name: device.name })} onClick=${open}><${Sign} path=${SIGNS.right} /></button>`}
    ${level !== null && html`<input class="range" type="range" min="0" max="100" value=${level} aria-label=${`${name}: ${label("level")}`} aria-valuetext=${state} onChange=${(event) => set(event.target.valueAsNumber)} />`}
    ${asks && act && html`<span class="asks"><${HoldButton} isAsked=${asks === "key"} text=${verb} onHeld=${() => { setAsks(""); perform(device, act, { isHeld: true }); }} /><button type="button" class="no" aria-label=${say("not now")} onClick=${() => setAsks("")}><${Sign} path=${SIGNS.close} /></button></span>`}
  </div>`;
}
