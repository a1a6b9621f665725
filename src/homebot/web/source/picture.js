// The newest picture of a camera, a cover or a map, asked for again while it is looked at.
import { signal } from "@preact/signals";
import { useState } from "preact/hooks";
import { ask, call, onOpen } from "./door.js";
import { html } from "./html.js";
import { say, sayReason } from "./language.js";
import { useOpen } from "./opened.js";
import { capital } from "./words.js";

const AGAIN = 2000; // ms
const SELDOM = 15_000; // of what changes seldom, or failed
const PATIENCE = 15; // seconds

/** The names of pictures at addresses of the owner: of devices, or of cameras without one. */
export const named = signal([]);
onOpen(() => call("/page/pictures").then((answer) => (named.value = answer.names), () => {}));

const isNamed = (device, name) => [device.id, device.name, device.given].some((one) => one.toLowerCase() === name.toLowerCase());
export const isOfDevice = (devices, name) => devices.some((one) => isNamed(one, name));
/** Whether a device has a picture for sure. */
export const hasPicture = (device) => device.type === "camera" || named.value.some((name) => isNamed(device, name));

/** The picture of a device or a name; *isExtra* where there may be none, which is no problem. */
export function Picture({ of, text, isExtra = false }) {
  const [found, setFound] = useState({ source: "", problem: "" });
  useOpen(async (isCurrent) => {
    const { success, message, media_type: type, data } = await ask("/page/picture", { device: of }, PATIENCE);
    if (isCurrent()) setFound((old) => (success ? { source: `data:${type};base64,${data}`, problem: "" } : { ...old, problem: message }));
    return success && !isExtra ? AGAIN : SELDOM;
  }, [of]);
  const { source, problem } = found;
  if (isExtra && (!source || problem)) return null;
  return html`<figure class="picture">${source ? html`<img src=${source} alt=${text} class=${problem ? "old" : ""} />` : html`<span class="pane"></span>`}
    ${problem && html`<figcaption>${source && say("This picture is no longer new.")} ${capital(sayReason(problem))}</figcaption>`}</figure>`;
}
