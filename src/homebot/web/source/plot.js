// A plot over time, as lines of SVG that fill their box; its texts grow with those of the page.
import { useState } from "preact/hooks";
import { zone } from "./clock.js";
import { html } from "./html.js";
import { say } from "./language.js";
import { clock, day, hour } from "./words.js";

const [WIDTH, HEIGHT] = [1000, 180];
const [LINES, MOMENTS, LONG_MOMENTS] = [4, 7, 3]; // at most, across, along, and along with seconds
const [HOUR, DAY] = [3600, 86_400]; // seconds
const STEPS = [1, 5, 15, 60, 300, 900, HOUR / 2, HOUR, 3 * HOUR, 6 * HOUR, 12 * HOUR, DAY, 2 * DAY, 7 * DAY, 14 * DAY, 31 * DAY, 92 * DAY, 366 * DAY];

/**
 * A plot from `from` to `to`: `values` has a list for each of `names`, null for a gap; `isStepped` where a value lasts
 * until the next one; `most` is the largest possible value; `text` writes a number; `isFlag` where 0 and 1 are all there is.
 */
export function Plot({ label, times, values, names, from = times[0], to = times.at(-1), most, isStepped = false, isFlag = false, text = String }) {
  const [index, setIndex] = useState(null);
  const span = Math.max(to - from, 1);
  const known = values.flat().filter((value) => value != null);
  const [low, high] = known.length ? rangeOf(Math.min(...known), Math.max(...known), most) : [0, 1];
  const x = (at) => ((at - from) / span) * WIDTH;
  const y = (value) => ((high - value) / (high - low)) * HEIGHT;
  const follow = (event) => {
    const box = event.currentTarget.getBoundingClientRect();
    const at = from + (span * (event.clientX - box.x)) / box.width;
    setIndex(times.reduce((best, time, own) => (Math.abs(time - at) < Math.abs(times[best] - at) ? own : best), 0));
  };
  const at = Math.min(index ?? Infinity, times.length - 1);
  const shown = names.map((name, one) => `${name} ${values[one][at] == null ? say("unknown") : text(round(values[one][at]))}`.trim());
  const lines = isFlag ? [0, 1] : linesOf(low, high);
  const short = span > 2 * DAY ? day.value : span < 300 ? clock.value : hour.value;
  const parts = values.map((row) => partsOf(times, row));
  const pathOf = (part) => part.map(([time, value], own) => `${!own ? "M" : isStepped ? `H${x(time).toFixed(1)}V` : "L"}${own && isStepped ? "" : `${x(time).toFixed(1)},`}${y(value).toFixed(1)}`).join("");
  return html`<figure class="plot">
    <div role="img" aria-label=${say("{what} over time, {count} points", { what: label, count: times.length })} onPointerMove=${follow} onPointerLeave=${() => setIndex(null)}>
      <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none">
        ${lines.map((one) => html`<path key=${one} class="grid" d=${`M0,${y(one)}H${WIDTH}`} />`)}
        ${names.length === 1 && parts[0].map((part, own) => html`<path key=${own} class="under" d=${`${pathOf(part)}V${HEIGHT}H${x(part[0][0]).toFixed(1)}Z`} />`)}
        ${parts.map((row, own) => html`<path key=${own} class="line" d=${row.map(pathOf).join("")} />`)}
        ${index !== null && html`<path class="grid at" d=${`M${x(times[at])},0V${HEIGHT}`} />`}
      </svg>
      ${lines.map((one) => html`<span key=${one} style=${{ insetBlockStart: `${(100 * y(one)) / HEIGHT}%` }}>${text(round(one))}</span>`)}
    </div>
    <p class="moments" aria-hidden="true">${momentsOf(from, span, short === clock.value ? LONG_MOMENTS : MOMENTS).map((one) => html`<span key=${one} style=${{ insetInlineStart: `${x(one) / (WIDTH / 100)}%` }}>${short.format(one * 1000)}</span>`)}</p>
    <figcaption><time>${index === null ? say("now") : `${day.value.format(times[at] * 1000)} ${clock.value.format(times[at] * 1000)}`}</time> ${shown.join(", ")}</figcaption>
  </figure>`;
}

const round = (value) => Number(value.toFixed(Math.abs(value) < 10 ? 2 : 1));

/** The points between two gaps, of each part. */
function partsOf(times, row) {
  const parts = [[]];
  row.forEach((value, own) => (value == null ? parts.push([]) : parts.at(-1).push([times[own], value])));
  return parts.filter((part) => part.length);
}

/** From 0 on, or closer where all values are far from it. */
function rangeOf(least, most, limit) {
  const end = most <= limit ? limit : Infinity;
  if (least >= 0 && least < most * 0.8) return [0, Math.min(most * 1.1, end) || 1];
  const room = (most - least) * 0.15 || Math.abs(most) * 0.1 || 1;
  return [least >= 0 ? Math.max(0, least - room) : least - room, Math.min(most + room, end)];
}

/** Round numbers within a range. */
function linesOf(low, high) {
  const least = (high - low) / LINES;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].find((one) => one * power >= least) * power;
  const first = Math.ceil(low / step);
  return Array.from({ length: Math.floor(high / step) - first + 1 }, (_, own) => (first + own) * step);
}

/** Round moments of the house's clock, away from both ends, whose texts would leave the plot. */
function momentsOf(from, span, most) {
  const step = STEPS.find((one) => span / one <= most) ?? STEPS.at(-1);
  const ahead = aheadOf(from);
  const found = [];
  for (let at = Math.ceil((from + ahead) / step) * step - ahead; at < from + span; at += step) found.push(at - (step < DAY ? 0 : aheadOf(at) - ahead)); // a day may have 25 hours
  const edge = span * (most < MOMENTS ? 0.2 : 0.05);
  return found.filter((at) => at > from + edge && at < from + span - edge);
}

/** By how many seconds the house's clock is ahead of UTC. */
const aheadOf = (at) => Date.parse(`${new Intl.DateTimeFormat("sv-SE", { timeZone: zone.value, dateStyle: "short", timeStyle: "medium" }).format(at * 1000).replace(" ", "T")}Z`) / 1000 - Math.floor(at);
