// The next time at which a routine changes a device.
import { useState } from "preact/hooks";
import { call } from "../../door.js";
import { html } from "../../html.js";
import { say } from "../../language.js";
import { useOpen } from "../../opened.js";
import { seconds, timeIn } from "../../words.js";

export function Next({ device }) {
  const [found, setFound] = useState(null);
  useOpen(() => void call("/routines/list", { device: device.id }).then(setFound, () => {}), [device.id]);
  const [first] = (found?.routines ?? []).filter((one) => one.enabled && seconds(one.next) > 0).sort((a, b) => seconds(a.next) - seconds(b.next));
  return first && html`<p class="quiet">${say("next")} ${timeIn(found.zone, first.next)}: ${first.steps.join(", ")}</p>`;
}
