// Rates, waiting messages and losses, as plots; while this view is open.
import { useEffect, useState } from "preact/hooks";
import { call, connection } from "../door.js";
import { received } from "../house.js";
import { html } from "../html.js";
import { Plot } from "../plot.js";
import { label } from "../words.js";

const EVERY = 2000; // ms
const MOST = 300; // samples
const LOSSES = ["messages_lost", "log_lines_lost", "calls_refused", "answers_late", "loop_blocks", "callback_failures"];

export function Rates() {
  const [samples, setSamples] = useState([]);
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return undefined;
    let before = { at: performance.now(), changes: received.changes };
    const timer = setInterval(async () => {
      const asked = performance.now();
      const health = await call("/homebot/health").catch(() => null);
      if (!health) return;
      const at = performance.now();
      const counts = new Map(health.counts.map((one) => [one.name, one.count]));
      const rate = ((received.changes - before.changes) * 1000) / (at - before.at);
      before = { at, changes: received.changes };
      setSamples((old) => [...old, { at: Date.now() / 1000, rate, delay: at - asked, losses: LOSSES.map((name) => counts.get(name) ?? 0) }].slice(-MOST));
    }, EVERY);
    return () => clearInterval(timer);
  }, [isOpen]);
  if (!samples.length) return html`<p class="empty">The first values come in two seconds.</p>`;
  const times = samples.map((one) => one.at);
  const last = samples[samples.length - 1];
  return html`
    <section><h2>Changes a second <small>${last.rate.toFixed(1)}</small></h2>
      <${Plot} label="changes a second" times=${times} values=${[samples.map((one) => one.rate)]} names=${["changes/s"]} /></section>
    <section><h2>Answer to a call <small>${last.delay.toFixed(1)} ms</small></h2>
      <${Plot} label="milliseconds until an answer" times=${times} values=${[samples.map((one) => one.delay)]} names=${["ms"]} /></section>
    <section><h2>Lost or late since the start</h2>
      <table class="facts"><tbody>
        ${LOSSES.map((name, index) => html`<tr key=${name}><th scope="row">${label(name)}</th><td>${last.losses[index]}</td></tr>`)}
      </tbody></table></section>`;
}
