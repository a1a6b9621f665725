// A device that waits to be paired: by its button or its code, with the seconds that are left and what came by it.
import { useEffect, useState } from "preact/hooks";
import { ask } from "./door.js";
import { shown } from "./house.js";
import { html, written } from "./html.js";
import { say, sayReason } from "./language.js";

const MORE = 10; // seconds after which no answer comes any more

export function Unpaired({ gateway, unpaired }) {
  const { device, name, takes_code: takesCode, within_s: within, problem } = unpaired;
  const [left, setLeft] = useState(0);
  const [before, setBefore] = useState(null);
  const [answer, setAnswer] = useState(null);
  useEffect(() => {
    if (left <= 0) return undefined;
    const timer = setTimeout(() => setLeft(left - 1), 1000);
    return () => clearTimeout(timer);
  }, [left]);
  const pair = async (event) => {
    const code = written(event).get("code")?.trim() ?? "";
    setBefore(new Set(shown.value.map((one) => one.id)));
    setAnswer(null);
    setLeft(Math.round(within));
    setAnswer(await ask(`/gateway/${gateway}/pair`, { device, code }, within + MORE));
    setLeft(0);
  };
  const added = before ? shown.value.filter((one) => !before.has(one.id)) : [];
  const isPaired = answer?.success;
  const isDone = isPaired && device; // without one, more devices may have a code
  return html`<form class="box" aria-label=${name} onSubmit=${pair}><h3><bdi>${name}</bdi></h3>
    ${problem ? html`<p>${sayReason(problem)}</p>` : !isDone && html`
      ${takesCode ? html`<label><span>${say("The code on the device")}</span> <input name="code" required maxlength="255" autocomplete="off" inputmode="numeric" /></label>` : html`<p>${say("Press the button on the device, then “pair”.")}</p>`}
      <p class="choices"><button disabled=${left > 0}>${say("pair|do")}</button> ${left > 0 && html`<span role="timer">${say(takesCode ? "{count} s left" : "Press its button now: {count} s left", { count: left })}</span>`}</p>`}
    <div role="status">${answer && !isPaired && html`<p class="bad">${sayReason(answer.message)}</p>`}
      ${isPaired && html`<p>${say("{name} is paired.", { name: answer.name || name })}</p><p>${added.length ? `${say("Found:")} ${added.map((one) => one.name).join(", ")}` : say("Its devices appear here.")}</p>`}</div>
  </form>`;
}
