// The history of a device: one of its values as a plot, and its energy by day.
import { useState } from "preact/hooks";
import { now } from "../../clock.js";
import { call } from "../../door.js";
import { html } from "../../html.js";
import { locale, numberText, say, sayReason } from "../../language.js";
import { useOpen } from "../../opened.js";
import { Plot } from "../../plot.js";
import { label, unitOf, wordsOf } from "../../words.js";

const PERIODS = [["1 h", 3600], ["24 h", 86_400], ["7 d", 604_800], ["30 d", 2_592_000], ["1 y", 31_536_000]]; // seconds
const POINTS = 300;
const LEAST = 60; // seconds of a plot; it begins with the first value

export function History({ device }) {
  const kept = [...device.states.values()].filter((one) => typeof one.value === "number" || typeof one.value === "boolean");
  kept.sort((a, b) => (b.capability === "power") - (a.capability === "power")); // of a plug, what it draws before whether it is on
  const [chosen, setChosen] = useState(null);
  const [period, setPeriod] = useState(86_400);
  const [answer, setAnswer] = useState(null);
  const reading = chosen ?? kept[0];
  useOpen(() => {
    if (!reading) return;
    const to = now();
    const asked = { device: device.id, part: reading.part, capability: reading.capability, points: POINTS, since: { sec: Math.max(0, Math.floor(to - period)), nanosec: 0 } };
    call("/history/read", asked).then(
      (found) => setAnswer({ ...found, now: to, period, capability: reading.capability }),
      (error) => setAnswer({ message: error.message, series: [] }),
    );
  }, [device.id, reading?.part, reading?.capability, period]);
  if (!reading) return null;
  return html`<section>
    <h2>${say("History")}</h2>
    <div class="choices">
      <select aria-label=${say("value")} onChange=${(event) => setChosen(kept[event.target.selectedIndex])}>
        ${kept.map((one) => html`<option key=${`${one.part} ${one.capability}`}>${label(one.capability)}</option>`)}
      </select>
      ${PERIODS.map(([text, value]) => html`<button key=${value} type="button" aria-pressed=${value === period} onClick=${() => setPeriod(value)}>${text}</button>`)}
    </div>
    ${answer ? html`<${Series} answer=${answer} />` : html`<p class="empty">…</p>`}
    ${kept.some((one) => one.capability.startsWith("energy")) && html`<${Energy} id=${device.id} />`}
  </section>`;
}

function Series({ answer }) {
  const found = answer.series.find((one) => one.times.length && (one.values.length || wordsOf(one.capability)));
  if (!found) return html`<p class="empty">${sayReason(answer.message ?? "") || say("Nothing is kept of that time.")}</p>`;
  const words = found.values.length ? undefined : wordsOf(found.capability);
  const [times, values] = words ? flagsOf(found) : numbersOf(found, answer.now);
  const unit = unitOf({ unit: found.unit, name: found.capability });
  const text = (value) => (words ? say(words[value ? 1 : 0]) : `${numberText(value)} ${unit}`.trim());
  return html`<${Plot} label=${label(found.capability)} times=${times} values=${[values]} names=${[""]} from=${Math.max(answer.now - answer.period, Math.min(times[0], answer.now - LEAST))} to=${answer.now} most=${unit === "%" ? 100 : undefined} isStepped=${!found.width} isFlag=${Boolean(words)} text=${text} />`;
}

/** Numbers; a single value lasts until now. */
function numbersOf(series, now) {
  if (series.width) return [series.times, series.values];
  return [[...series.times, now], [...series.values, series.values[series.values.length - 1]]];
}

/** Words as 1 and 0, with a gap where none is known. */
function flagsOf({ times, ends, words }) {
  const at = [];
  const values = [];
  words.forEach((word, index) => {
    at.push(times[index]);
    values.push(word === "true" ? 1 : 0);
    const next = times[index + 1];
    if (next !== undefined && next - ends[index] < 0.001) return;
    at.push(ends[index]);
    values.push(next === undefined ? values[values.length - 1] : null);
  });
  return [at, values];
}

function Energy({ id }) {
  const [days, setDays] = useState([]);
  useOpen(() => void call("/history/energy", { device: id }).then((answer) => setDays(answer.days), () => {}), [id]);
  if (!days.length) return null;
  const most = Math.max(...days.map((one) => one.used)) || 1;
  return html`<h3>${say("Energy by day")}</h3>
    <table class="facts">
      <tbody>
        ${days.map(
          (one) => html`<tr key=${`${one.day} ${one.part}`}>
            <th scope="row">${one.day}</th>
            <td>${energyText(one.used)}${one.returned > 0 && `, ${say("{energy} returned", { energy: energyText(one.returned) })}`}</td>
            <td><meter min="0" max=${most} value=${one.used} aria-label=${say("energy of {day}", { day: one.day })}></meter></td>
          </tr>`,
        )}
      </tbody>
    </table>`;
}

const energyText = (value) => `${value.toLocaleString(locale.value, { minimumFractionDigits: 2, maximumFractionDigits: 2 })} kWh`;
