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

/** A view that is loaded when it is first shown. */
export function later(load) {
  let View = null;
  return function Later(props) {
    const [, setLoaded] = useState(View !== null);
    useEffect(() => {
      if (!View) Promise.all([load(), loadRest()]).then(([loaded]) => setLoaded((View = loaded) !== null), () => (isOutdated.value = true));
    }, []);
    return View && html`<${View} ...${props} />`;
  };
}

/** What the second file has. */
export const soon = (name) => later(async () => (await import("./soon.js"))[name]);
setTimeout(() => import("./soon.js").catch(() => {}), SOON);
