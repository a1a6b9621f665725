// The graph as a picture: those that publish, topics, those that listen.
import { useEffect, useState } from "preact/hooks";
import { call, connection } from "../door.js";
import { html } from "../html.js";

const ROW = 22;
const WIDTH = 900;
const COLUMNS = [10, 330, 650];

export function Graph() {
  const [ends, setEnds] = useState(null);
  const [chosen, setChosen] = useState("");
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (isOpen) call("/rosapi/endpoints").then((answer) => setEnds(answer.endpoints), () => {});
  }, [isOpen]);
  if (!ends) return html`<p class="empty">Asking homebot for its graph …</p>`;
  const links = ends.filter((one) => one.kind === "publisher" || one.kind === "subscription").filter((one) => !one.name.includes("/_"));
  const touches = (one) => !chosen || one.node === chosen || one.name === chosen;
  const topics = layer([...new Set(links.filter(touches).map((one) => one.name))]);
  const near = links.filter((one) => topics.has(one.name) && (touches(one) || chosen === one.name));
  const shown = chosen ? links.filter((one) => topics.has(one.name)) : near;
  const from = layer([...new Set(shown.filter((one) => one.kind === "publisher").map((one) => one.node))]);
  const to = layer([...new Set(shown.filter((one) => one.kind === "subscription").map((one) => one.node))]);
  const height = ROW * (Math.max(from.size, topics.size, to.size) + 2);
  const choose = (name) => () => setChosen(name === chosen ? "" : name);
  return html`
    <p>Left: nodes that publish. Middle: topics. Right: nodes that listen. ${chosen ? html`<button type="button" onClick=${choose(chosen)}>show all</button>` : "Choose one to see its own."}</p>
    <div class="scroll" role="region" tabindex="0" aria-label="graph"><svg class="graph" viewBox=${`0 0 ${WIDTH} ${height}`} width=${WIDTH} height=${height} role="group" aria-label=${`${from.size + to.size} nodes and ${topics.size} topics`}>
      ${shown.map((one) => {
        const isOut = one.kind === "publisher";
        const y = (isOut ? from : to).get(one.node);
        const topic = topics.get(one.name);
        const [x1, y1, x2, y2] = isOut ? [COLUMNS[0] + 240, y, COLUMNS[1], topic] : [COLUMNS[1] + 260, topic, COLUMNS[2], y];
        return html`<path key=${`${one.kind} ${one.node} ${one.name}`} class=${isOut ? "out" : "in"} d=${`M ${x1} ${y1} C ${x1 + 40} ${y1} ${x2 - 40} ${y2} ${x2} ${y2}`} />`;
      })}
      ${[from, topics, to].map((names, column) => [...names].map(([name, y]) => html`<text key=${`${column} ${name}`} class=${name === chosen ? "chosen" : ""} x=${COLUMNS[column]} y=${y + 4} onClick=${choose(name)}>${name.length > 38 ? `${name.slice(0, 37)}…` : name}<title>${name}</title></text>`))}
    </svg></div>
    <p class="choices"><label>Show <select value=${chosen} onChange=${(event) => setChosen(event.target.value)}>
      <option value="">all</option>
      ${[...new Set(links.flatMap((one) => [one.node, one.name]))].sort().map((name) => html`<option key=${name}>${name}</option>`)}
    </select></label></p>`;
}

const layer = (names) => new Map(names.sort().map((name, index) => [name, ROW * (index + 1)]));
