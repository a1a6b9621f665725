import uPlot from "uplot";
import { useEffect, useRef } from "preact/hooks";
import { html } from "./html.js";

const HEIGHT = 220;
const COLOURS = ["--accent", "--good", "--bad", "--quiet"];

/** A plot over time: `values` has a list for each of `names`, null for a gap. */
export function Plot({ label, times, values, names }) {
  const place = useRef(null);
  const plot = useRef(null);
  useEffect(() => {
    const style = getComputedStyle(place.current);
    const axis = { stroke: style.color, grid: { stroke: style.getPropertyValue("--line") }, ticks: { show: false } };
    const series = names.map((name, index) => ({
      label: name,
      stroke: style.getPropertyValue(COLOURS[index % COLOURS.length]),
      width: 2,
      points: { show: times.length < 2 },
    }));
    const options = { width: place.current.clientWidth, height: HEIGHT, series: [{}, ...series], axes: [axis, axis] };
    const own = new uPlot(options, [times, ...values], place.current);
    plot.current = own;
    const resize = new ResizeObserver(([entry]) => own.setSize({ width: entry.contentRect.width, height: HEIGHT }));
    resize.observe(place.current);
    return () => {
      resize.disconnect();
      own.destroy();
    };
  }, [names.join(" ")]);
  useEffect(() => plot.current?.setData([times, ...values]), [times, values]);
  return html`<div class="plot" role="img" aria-label=${`${label} over time, ${times.length} points`} ref=${place}></div>`;
}
