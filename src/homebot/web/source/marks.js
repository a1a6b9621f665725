// What "last known" means, and why a device is not known now.
import { computed } from "@preact/signals";
import { deviceOf, rooms } from "./house.js";
import { html } from "./html.js";
import { say } from "./language.js";

const isLastKnown = (device) => device.is_reachable && device.freshness === "unconfirmed" && [...device.states.values()].some((one) => one.value !== null);
const someAreLastKnown = computed(() => rooms.value.some(([, ids]) => ids.some((id) => isLastKnown(deviceOf(id).value))));

/** What "last known" means, once on a view where a device has that mark. */
export function LastKnown({ device }) {
  return (device ? isLastKnown(device) : someAreLastKnown.value) && html`<p class="legend"><span class="mark">${say("last known")}</span> ${say("was kept from before: the device has not reported since homebot started.")}</p>`;
}

export function Marks({ device }) {
  const marks = [];
  if (!device.is_reachable) marks.push(["bad", "unreachable"]);
  else if (device.freshness === "stale") marks.push(["bad", "silent"]);
  else if (isLastKnown(device)) marks.push(["", "last known"]);
  if (device.waits) marks.push(["", "not approved"]);
  return marks.map(([kind, text]) => html`<span class=${`mark ${kind}`} key=${text}>${say(text)}</span>`);
}
