// Today of a device in one small drawing: a line of its number, or a strip of when it was on or open.
import { useState } from "preact/hooks";
import { now } from "../../clock.js";
import { call } from "../../door.js";
import { html } from "../../html.js";
import { say } from "../../language.js";
import { useOpen } from "../../opened.js";
import { hour, label, valueText } from "../../words.js";

const HOURS = 24;
const [WIDTH, HEIGHT] = [480, 64];
/** The value that tells most, of those that a device has. */
const TELLING = ["power", "local_temperature", "temperature", "humidity", "on_off", "contact", "occupancy", "level", "position", "illuminance", "battery"];

export function Mini({ device, capability }) {
  const own = capability ?? TELLING.find((one) => [...device.states.values()].some(({ capability: name, value }) => name === one && value !== null));
  const [answer, setAnswer] = useState(null);
  useOpen(() => {
    if (!own) return;
    const to = now();
    const since = to - HOURS * 3600;
    call("/history/read", { device: device.id, capability: own, points: 120, since: { sec: Math.floor(since), nanosec: 0 } }).then((found) => setAnswer({ since, to, series: found.series.find((one) => one.times.length) }), () => {});
  }, [device.id, own]);
  const { series, since, to } = answer ?? {};
  if (!series) return null;
  const x = (at) => Math.max(0, (WIDTH * (at - since)) / (to - since));
  const text = `${label(own)}, ${hour.value.format(since * 1000)} – ${say("now")}`;
  const marks = [0, 1, 2, 3, 4].map((at) => hour.value.format((since + (at * HOURS * 3600) / 4) * 1000));
  return html`<section class="mini"><h3>${say("the last 24 hours")} <small>${label(own)}</small></h3>
    <svg viewBox=${`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" role="img" aria-label=${text}>${series.values.length ? html`<${Line} series=${series} x=${x} to=${to} />` : html`<rect class="base" y="20" width=${WIDTH} height="24" />${series.words.map((word, at) => word === "true" && html`<rect key=${at} class="on" y="20" height="24" x=${x(series.times[at])} width=${Math.max(2, x(series.ends[at]) - x(series.times[at]))} />`)}`}</svg>
    ${series.values.length > 0 && html`<p class="span"><span>${valueText(own, Math.min(...series.values))}</span><span>${valueText(own, Math.max(...series.values))}</span></p>`}
    <p class="axis" aria-hidden="true">${marks.map((one) => html`<span key=${one}>${one}</span>`)}</p></section>`;
}

function Line({ series: { times, values }, x, to }) {
  const [least, most] = [Math.min(...values), Math.max(...values)];
  const y = (value) => (most === least ? HEIGHT / 2 : 4 + ((HEIGHT - 8) * (most - value)) / (most - least));
  const points = [...times.map((at, index) => [x(at), y(values[index])]), [x(to), y(values.at(-1))]].map((point) => point.map((one) => one.toFixed(1)).join(","));
  return html`<path class="under" d=${`M${points[0].split(",")[0]},${HEIGHT} L${points.join(" L")} L${WIDTH},${HEIGHT}Z`} /><path class="line" d=${`M${points.join(" L")}`} />`;
}
