// Rates, waiting messages and losses, as plots; while this view is open.
import { useEffect, useState } from "preact/hooks";
import { now } from "../clock.js";
import { call, connection } from "../door.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { Plot } from "../plot.js";

const EVERY = 2000; // ms
const MOST = 300; // samples
const BUSIEST = 10; // topics

export function Rates() {
  const [samples, setSamples] = useState([]);
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return undefined;
    let before = null;
    const look = async () => {
      const load = await call("/rosapi/load").catch(() => null);
      if (!load) return;
      if (before) {
        const sample = between(before, load);
        setSamples((old) => [...old, sample].slice(-MOST));
      }
      before = load;
    };
    look();
    const timer = setInterval(look, EVERY);
    return () => clearInterval(timer);
  }, [isOpen]);
  if (!samples.length) return html`<p class="empty">${say("The first values come in two seconds.")}</p>`;
  const times = samples.map((one) => one.at);
  const last = samples[samples.length - 1];
  const from = Math.min(times[0], last.at - 60);
  const plot = (label, names, text) => html`<${Plot} label=${label} times=${times} from=${from} values=${names.map(([, value]) => samples.map(value))} names=${names.map(([name]) => name)} text=${text} />`;
  return html`
    <div class="columns">
      <section><h2>${say("Messages")}</h2>${plot(say("messages a second"), [["", (one) => one.rate]], (value) => `${value}/s`)}</section>
      <section><h2>${say("Queues and losses")}</h2>${plot(say("messages that wait, and lost ones"), [[say("waiting"), (one) => one.waiting], [say("lost"), (one) => one.lost]])}</section>
      <section><h2>${say("Event loop")}</h2>${plot(say("delay of the event loop"), [[say("late by"), (one) => one.lag]], (value) => `${value} ms`)}</section>
    </div>
    <section>
      <h2>${say("Busiest topics")}</h2>
      <div class="scroll" role="region" tabindex="0" aria-label=${say("Busiest topics")}><table class="numbers">
        <thead><tr><th>${say("Topic")}</th><th>${say("Messages")}/s</th><th>${say("waiting")}</th><th>${say("lost")}</th><th>${say("Slowest handler")}</th></tr></thead>
        <tbody>
          ${last.topics.slice(0, BUSIEST).map((one) => html`<tr key=${one.topic}>
            <th scope="row">${one.topic}</th><td>${one.rate.toFixed(1)}</td><td>${one.waiting}</td><td>${one.lost}</td>
            <td>${one.slowest > 0 && `${(one.slowest * 1000).toFixed(1)} ms, ${one.by.replace(/^\//, "")}`}</td>
          </tr>`)}
        </tbody>
      </table></div>
    </section>`;
}

/** The load between two answers, as `homebot top` has it; the busiest topics first. */
function between(before, load) {
  const length = Math.max(load.at - before.at, 0.001);
  const old = new Map(before.topics.map((one) => [one.topic, one.published]));
  const topics = load.topics.map(({ topic, published }) => {
    const queues = load.queues.filter((one) => one.topic === topic);
    const slowest = queues.reduce((most, one) => (one.slowest > most.slowest ? one : most), { slowest: 0, node: "" });
    return {
      topic,
      rate: Math.max(0, published - (old.get(topic) ?? published)) / length,
      waiting: Math.max(0, ...queues.map((one) => one.waiting)),
      lost: sum(queues, "lost"),
      slowest: slowest.slowest,
      by: slowest.node,
    };
  });
  topics.sort((a, b) => b.rate - a.rate || b.waiting - a.waiting || a.topic.localeCompare(b.topic));
  return { at: now(), rate: sum(topics, "rate"), waiting: sum(topics, "waiting"), lost: sum(topics, "lost"), lag: load.lag * 1000, topics };
}

const sum = (list, name) => list.reduce((all, one) => all + one[name], 0);
