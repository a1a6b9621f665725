// The graph as a picture: nodes that publish, topics, nodes that subscribe.
import { useState } from "preact/hooks";
import { call } from "../door.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { useOpen } from "../opened.js";

const ROW = 26;
const WIDTH = 1000;
const FROM = 230; // right edge of the nodes that publish
const TOPIC = [350, 650];
const TO = 770; // left edge of the nodes that subscribe
const LONGEST = 36;

export function Graph() {
  const [ends, setEnds] = useState(null);
  const [chosen, setChosen] = useState("");
  useOpen(() => void call("/rosapi/endpoints").then((answer) => setEnds(answer.endpoints), () => {}));
  if (!ends) return html`<p class="empty">${say("Asking homebot for its graph …")}</p>`;
  const links = ends.filter((one) => (one.kind === "publisher" || one.kind === "subscription") && !one.name.includes("/_"));
  const near = new Set(links.filter((one) => !chosen || one.node === chosen || one.name === chosen).map((one) => one.name));
  const shown = links.filter((one) => near.has(one.name));
  const published = shown.filter((one) => one.kind === "publisher");
  const subscribed = shown.filter((one) => one.kind === "subscription");
  const from = column([...new Set(published.map((one) => one.node))].sort());
  const topics = column(ordered([...near], published, from));
  const to = column(ordered([...new Set(subscribed.map((one) => one.node))], subscribed.map(({ node, name }) => ({ node: name, name: node })), topics));
  const height = ROW * (Math.max(from.size, topics.size, to.size) + 1);
  // Each column is in the middle of the picture.
  const y = (names, name) => names.get(name) + (height - ROW * (names.size + 1)) / 2;
  const choose = (name) => () => setChosen(name === chosen ? "" : name);
  const text = (name, x, at, anchor) => html`<text key=${`${anchor} ${name}`} class=${name === chosen ? "chosen" : ""} text-anchor=${anchor} x=${x} y=${at + 4} onClick=${choose(name)}>${name.length > LONGEST ? `${name.slice(0, LONGEST - 1)}…` : name}<title>${name}</title></text>`;
  return html`<section>
    <p class="choices"><label>${say("Show")} <select value=${chosen} onChange=${(event) => setChosen(event.target.value)}>
      <option value="">${say("all")}</option>
      ${[...new Set(links.flatMap((one) => [one.node, one.name]))].sort().map((name) => html`<option key=${name}>${name}</option>`)}
    </select></label> <small>${say("Nodes on the left publish topics, nodes on the right subscribe to them.")}</small></p>
    <div class="scroll" role="region" tabindex="0" aria-label=${say("graph")}><svg class="graph" viewBox=${`0 0 ${WIDTH} ${height}`} role="group" aria-label=${say("{nodes} nodes and {topics} topics", { nodes: from.size + to.size, topics: topics.size })}>
      ${published.map((one) => curve(one, FROM + 8, y(from, one.node), TOPIC[0], y(topics, one.name)))}
      ${subscribed.map((one) => curve(one, TOPIC[1], y(topics, one.name), TO - 8, y(to, one.node)))}
      ${[...topics.keys()].map((name) => html`<rect key=${name} x=${TOPIC[0]} y=${y(topics, name) - 11} width=${TOPIC[1] - TOPIC[0]} height="22" rx="11" />`)}
      ${[...from.keys()].map((name) => text(name, FROM, y(from, name), "end"))}
      ${[...topics.keys()].map((name) => text(name, (TOPIC[0] + TOPIC[1]) / 2, y(topics, name), "middle"))}
      ${[...to.keys()].map((name) => text(name, TO, y(to, name), "start"))}
    </svg></div>
  </section>`;
}

const column = (names) => new Map(names.map((name, index) => [name, ROW * (index + 1)]));

/** `names` by the mean height of their neighbours, so that fewer lines cross. */
function ordered(names, links, neighbours) {
  const height = (name) => {
    const found = links.filter((one) => one.name === name).map((one) => neighbours.get(one.node));
    return found.length ? found.reduce((all, one) => all + one, 0) / found.length : Infinity;
  };
  const heights = new Map(names.map((name) => [name, height(name)]));
  return names.sort((a, b) => (heights.get(a) === heights.get(b) ? a.localeCompare(b) : heights.get(a) - heights.get(b)));
}

function curve(link, x1, y1, x2, y2) {
  return html`<path key=${`${link.kind} ${link.node} ${link.name}`} d=${`M ${x1} ${y1} C ${x1 + 60} ${y1} ${x2 - 60} ${y2} ${x2} ${y2}`} />`;
}
