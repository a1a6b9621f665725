// Views that are loaded when they are first shown.
import { effect, signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { connection } from "./door.js";
import { html } from "./html.js";
import { SOON, loadRest } from "./language.js";

/** Whether a view could not be loaded: homebot is away, or was updated, so that its files have other names. */
const isOutdated = signal(false);
const YOUNG = 5000; // ms in which a new load of the page would not help

effect(() => {
  if (isOutdated.value && connection.value.state === "open" && performance.now() > YOUNG) location.reload();
});

/** A view that is loaded when it is first shown, or once it is `begun`, with its texts. */
export function later(load, loadTexts = loadRest) {
  let View = null;
  let loading = null;
  function Later(props) {
    const [isDrawn, setDrawn] = useState(View !== null);
    useEffect(() => {
      if (!isDrawn) Later.begin().then(() => setDrawn(true), () => (isOutdated.value = true));
    }, []);
    return View && html`<${View} ...${props} />`;
  }
  Later.begin = () => (loading ??= Promise.all([load(), loadTexts()]).then(([loaded]) => (View = loaded)).finally(() => (loading = null)));
  return Later;
}

/** What a link may lead to at once: its texts are among those of the first view. */
export const soon = (name) => later(async () => (await import("./soon.js"))[name], () => null);
/** What a second touch shows. */
export const second = (name) => later(async () => (await import("./second.js"))[name]);
setTimeout(() => Promise.all([import("./soon.js"), import("./second.js")]).catch(() => {}), SOON);
