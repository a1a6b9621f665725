// How a finger, a mouse and a key are understood: a tap, a hold, a slide to the side; and the button that is held.
import { useEffect, useRef, useState } from "preact/hooks";
import { html } from "./html.js";
import { say } from "./language.js";

const SLIDE = 10; // px to the side from which on a touch is a slide, and up or down a scroll
const HOLD = 500; // ms
const CONFIRM = 1000; // ms for which what can let in is held

/** What a finger works: a long touch opens no menu, and a key that stays down presses it once. */
const isOurs = ({ target }) => target.closest?.(".main, .hold");
addEventListener("contextmenu", (event) => isOurs(event) && event.preventDefault());
addEventListener("keydown", (event) => event.repeat && isOurs(event) && event.preventDefault());

/** The touch that is followed: one at a time, as a second finger ends it. */
let touch = null;

function end() {
  clearTimeout(touch.timer);
  touch.watch.abort();
  const old = touch;
  touch = null;
  return old;
}

function give() {
  const { skips, slides, onSlide } = end();
  skips.current = true;
  if (slides) onSlide(null);
}

function move(event) {
  const own = touch;
  const [x, y] = [Math.abs(event.clientX - own.x), Math.abs(event.clientY - own.y)];
  if (!own.slides && y > SLIDE) return give();
  if (!own.slides && x > SLIDE) {
    if (!own.onSlide || own.isHeld) return give();
    own.slides = own.skips.current = true;
    clearTimeout(own.timer);
    own.button.setPointerCapture(event.pointerId);
  }
  if (own.slides) own.onSlide((own.value = Math.round(Math.min(100, Math.max(1, (100 * (event.clientX - own.box.left)) / own.box.width)))));
}

function up() {
  const old = end();
  if (old.slides) old.onSlid(old.value);
  else if (old.isHeld) setTimeout(old.onHold); // only now: the sheet must not take the touch that opened it
}

const WAYS = { pointermove: move, pointerup: up, pointercancel: give };

/** Follow a pointer: a short touch, a hold, or a slide to the side; a scroll up or down is none of them. */
export function useTouch({ onTap, onHold, onSlide, onSlid }) {
  const skips = useRef(true); // the click that ends a hold or a slide, or a touch that began elsewhere
  return {
    onPointerDown: (event) => {
      if (touch) return give(); // a second finger
      if (event.button || !event.isPrimary) return;
      const { clientX: x, clientY: y, currentTarget: button, pointerId } = event;
      const own = { x, y, button, skips, onHold, onSlide, onSlid, box: button.getBoundingClientRect(), watch: new AbortController() };
      skips.current = false;
      own.timer = setTimeout(() => {
        skips.current = own.isHeld = true;
        navigator.vibrate?.(10);
      }, HOLD);
      touch = own;
      for (const [kind, follow] of Object.entries(WAYS)) addEventListener(kind, (event) => event.pointerId === pointerId && follow(event), { signal: own.watch.signal });
    },
    onClick: (event) => {
      if (skips.current && event.detail) return;
      skips.current = true;
      onTap(event);
    },
  };
}

/** A button that acts after it was held for a second; by keys or a screen reader, at the second press. */
export function HoldButton({ text, onHeld, isAsked = false, name = "" }) {
  const [state, setState] = useState(isAsked ? "asked" : "");
  const timer = useRef(0);
  const stop = () => {
    clearTimeout(timer.current);
    setState((old) => (old === "holding" ? "" : old));
  };
  useEffect(() => () => clearTimeout(timer.current), []);
  const start = (event) => {
    if (event.button) return;
    setState("holding");
    timer.current = setTimeout(() => {
      setState("");
      onHeld();
    }, CONFIRM);
  };
  const press = (event) => {
    if (event.detail) return; // of a pointer
    setState(state === "asked" ? "" : "asked");
    if (state === "asked") onHeld();
  };
  return html`<button type="button" class=${`hold ${state} ${name}`} ref=${(own) => isAsked && own && !own.wasSeen && ((own.wasSeen = true), own.focus())} onPointerDown=${start} onPointerUp=${stop} onPointerLeave=${stop} onPointerCancel=${stop} onClick=${press}><span class="fill"></span><span aria-live="polite">${say(state === "asked" ? "Press again to {what}" : "Hold to {what}", { what: text })}</span></button>`;
}
