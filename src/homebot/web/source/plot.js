import uPlot from "uplot";
import { useEffect, useRef, useState } from "preact/hooks";
import { html } from "./html.js";
import { say } from "./language.js";
import { clock, day, hour } from "./words.js";

const HEIGHT = 180;
const COLOURS = ["--accent", "--alarm"];
const SOON = 172_800; // seconds that are shown with the time of day

/**
 * A plot over time, from `from` to `to`: `values` has a list for each of `names`, null for a gap; `isStepped` where a
 * value lasts until the next one; `most` is the largest possible value; `text` writes a number; `isFlag` where 0 and 1 are all there is.
 */
export function Plot({ label, times, values, names, from, to, most, isStepped = false, isFlag = false, text = String }) {
  const place = useRef(null);
  const plot = useRef(null);
  const span = useRef([]);
  const write = useRef(text);
  write.current = text;
  const [index, setIndex] = useState(null);
  span.current = [from ?? times[0], Math.max(to ?? times[times.length - 1], (from ?? times[0]) + 1)];
  useEffect(() => {
    const style = getComputedStyle(place.current);
    const axis = { stroke: style.getPropertyValue("--ink-2"), grid: { stroke: style.getPropertyValue("--line"), width: 1 }, ticks: { show: false }, font: "12px system-ui, sans-serif" };
    const series = names.map((name, at) => ({
      label: name,
      stroke: style.getPropertyValue(COLOURS[at % COLOURS.length]),
      width: 2,
      fill: names.length === 1 ? `color-mix(in srgb, ${style.getPropertyValue(COLOURS[0])} 11%, transparent)` : undefined,
      paths: isStepped ? uPlot.paths.stepped({ align: 1 }) : uPlot.paths.linear(),
      points: { show: false },
    }));
    const short = (at) => (span.current[1] - span.current[0] > SOON ? day.value : span.current[1] - span.current[0] < 300 ? clock.value : hour.value).format(at * 1000);
    const options = {
      width: place.current.clientWidth,
      height: HEIGHT,
      legend: { show: false },
      cursor: { y: false, points: { show: false }, drag: { x: false } },
      scales: { x: { range: () => span.current }, y: { range: (_, low, high) => rangeOf(low, high, most) } },
      series: [{}, ...series],
      axes: [
        { ...axis, space: 90, size: 30, values: (_, splits) => splits.map(short) },
        { ...axis, size: 60, values: (_, splits) => splits.map((one) => write.current(round(one))), ...(isFlag ? { splits: () => [0, 1] } : {}) },
      ],
      hooks: { setCursor: [(own) => setIndex(own.cursor.idx ?? null)] },
    };
    const own = new uPlot(options, [times, ...values], place.current);
    plot.current = own;
    const resize = new ResizeObserver(([entry]) => own.setSize({ width: entry.contentRect.width, height: HEIGHT }));
    resize.observe(place.current);
    return () => {
      resize.disconnect();
      own.destroy();
    };
  }, [names.join(" "), isStepped, isFlag]);
  useEffect(() => plot.current?.setData([times, ...values]), [times, values]);
  const at = index ?? times.length - 1;
  const shown = names.map((name, one) => `${name} ${values[one][at] == null ? say("unknown") : text(round(values[one][at]))}`.trim());
  return html`<figure class="plot">
    <div role="img" aria-label=${say("{what} over time, {count} points", { what: label, count: times.length })} ref=${place}></div>
    <figcaption><time>${index === null ? say("now") : `${day.value.format(times[at] * 1000)} ${clock.value.format(times[at] * 1000)}`}</time> ${shown.join(", ")}</figcaption>
  </figure>`;
}

const round = (value) => Number(value.toFixed(Math.abs(value) < 10 ? 2 : 1));

/** From 0 on, or closer where all values are far from it. */
function rangeOf(least, most, limit) {
  if (least === null) return [0, 1];
  const end = most <= limit ? limit : Infinity;
  if (least >= 0 && least < most * 0.8) return [0, Math.min(most * 1.1, end) || 1];
  const room = (most - least) * 0.15 || Math.abs(most) * 0.1 || 1;
  return [least >= 0 ? Math.max(0, least - room) : least - room, Math.min(most + room, end)];
}
