// How a finger, a mouse and a key are understood: a tap, a hold, a slide to the side; and the button that is held.
import { useEffect, useRef, useState } from "preact/hooks";
import { html } from "./html.js";
import { say } from "./language.js";

const SLIDE = 10; // px to the side from which on a touch is a slide, and up or down a scroll
const HOLD = 500; // ms
const CONFIRM = 1000; // ms for which what can let in is held

const withoutMenu = (event) => event.preventDefault();
/** A key that stays down presses a button again and again. */
const withoutRepeat = (event) => event.repeat && event.preventDefault();

/** Follow a pointer: a short touch, a hold, or a slide to the side; a scroll up or down is none of them. */
export function useTouch({ onTap, onHold, onSlide, onSlid }) {
  const state = useRef(null);
  const skips = useRef(true); // the click that ends a hold or a slide, or a touch that began elsewhere
  const end = () => {
    clearTimeout(state.current?.timer);
    const old = state.current;
    state.current = null;
    return old;
  };
  const give = () => {
    skips.current = true;
    const old = end();
    if (old?.slides) onSlide(null);
  };
  useEffect(() => () => void end(), []);
  return {
    onPointerDown: (event) => {
      if (state.current) return give(); // a second finger
      if (event.button || !event.isPrimary) return;
      skips.current = false;
      const own = { x: event.clientX, y: event.clientY, box: event.currentTarget.getBoundingClientRect() };
      own.timer = setTimeout(() => {
        skips.current = own.isHeld = true;
        navigator.vibrate?.(10);
      }, HOLD);
      state.current = own;
    },
    onPointerMove: (event) => {
      const own = state.current;
      if (!own) return;
      const [x, y] = [Math.abs(event.clientX - own.x), Math.abs(event.clientY - own.y)];
      if (!own.slides && y > SLIDE) return give();
      if (!own.slides && x > SLIDE) {
        if (!onSlide || own.isHeld) return give();
        own.slides = skips.current = true;
        clearTimeout(own.timer);
        event.currentTarget.setPointerCapture(event.pointerId);
      }
      if (own.slides) onSlide((own.value = Math.round(Math.min(100, Math.max(1, (100 * (event.clientX - own.box.left)) / own.box.width)))));
    },
    onPointerUp: () => {
      const old = end();
      if (old?.slides) onSlid(old.value);
      else if (old?.isHeld) setTimeout(onHold); // only now: the sheet must not take the touch that opened it
    },
    onPointerCancel: give,
    onContextMenu: withoutMenu,
    onKeyDown: withoutRepeat,
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
  return html`<button type="button" class=${`hold ${state} ${name}`} ref=${(own) => isAsked && own && !own.wasSeen && ((own.wasSeen = true), own.focus())} onPointerDown=${start} onPointerUp=${stop} onPointerLeave=${stop} onPointerCancel=${stop} onContextMenu=${withoutMenu} onKeyDown=${withoutRepeat} onClick=${press}><span class="fill"></span><span aria-live="polite">${say(state === "asked" ? "Press again to {what}" : "Hold to {what}", { what: text })}</span></button>`;
}
