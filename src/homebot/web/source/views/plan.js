// The plan of the home, with its devices and robots, where places have geometry.
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { call, connection, subscribe } from "../door.js";
import { deviceOf, rooms as devicesOf } from "../house.js";
import { html } from "../html.js";
import { isActive, summary } from "../words.js";

const robots = signal(new Map());

export function Plan() {
  const [places, setPlaces] = useState(null);
  const [positions, setPositions] = useState([]);
  const [floor, setFloor] = useState(null);
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (!isOpen) return;
    call("/discovery/places").then(setPlaces, () => {});
    call("/discovery/find_devices").then((answer) => setPositions(answer.devices.flatMap(positionOf)), () => {});
  }, [isOpen]);
  useEffect(() => subscribe("/robots/poses", (pose) => (robots.value = new Map(robots.value).set(pose.robot, pose))), []);
  if (!places) return html`<p class="empty">Asking homebot for the plan …</p>`;
  const drawn = places.rooms.filter((room) => room.areas.length);
  if (!drawn.length)
    return html`<p class="empty">No room has a shape yet. Give it corners in the table [places.rooms], or import a map: homebot places import FILE.</p>`;
  const floors = [...new Set(drawn.map((room) => room.floor))];
  const shown = floor ?? floors[0];
  const rooms = drawn.filter((room) => room.floor === shown);
  const box = boxOf(rooms);
  const here = [...robots.value.values()].filter((pose) => pose.has_position && pose.counts && (floors.length < 2 || pose.floor === shown));
  const unit = Math.max(box.width, box.height) / 72; // the size of text
  const names = new Set(rooms.map((room) => room.name));
  const inside = new Map(devicesOf.value);
  const placed = new Map(positions.map((one) => [one.id, one]));
  return html`<section>
    ${floors.length > 1 && html`<p class="choices">${floors.map((one) => html`<button key=${one} type="button" aria-pressed=${one === shown} onClick=${() => setFloor(one)}>${one || "Ground"}</button>`)}</p>`}
    <div class="scroll" role="region" tabindex="0" aria-label="plan">
      <svg class="plan" viewBox=${`${box.left} ${-box.top} ${box.width} ${box.height}`} font-size=${unit} stroke-width=${unit / 9} role="group" aria-label=${`plan with ${rooms.length} rooms`}>
        ${rooms.map((room) => html`<${Room} key=${room.name} room=${room} unit=${unit} ids=${inside.get(room.name) ?? []} placed=${placed} />`)}
        ${places.doors.filter((door) => door.rooms.some((one) => names.has(one))).map((door) => html`<${Doorway} key=${door.name} door=${door} rooms=${rooms} unit=${unit} />`)}
        ${here.map((pose) => html`<g key=${pose.robot} class="robot" transform=${`translate(${pose.x} ${-pose.y}) scale(${unit})`}>
          <title>${pose.robot}</title>
          <circle r="1" />
          <path transform=${`rotate(${(-pose.yaw * 180) / Math.PI})`} d="M 0.65 0 L -0.35 0.45 L -0.35 -0.45 Z" />
          ${here.length > 1 && html`<text y="2.2">${pose.robot}</text>`}
        </g>`)}
      </svg>
    </div>
    <p class="legend">${["A full dot is on, open or occupied.", ...[...robots.value.values()].map((pose) => `${pose.robot}: ${pose.counts ? pose.room || "outside of all rooms" : "not known now"}.`)].join(" ")}</p>
  </section>`;
}

/** A room with its devices: at their positions, else in a list. */
function Room({ room, unit, ids, placed }) {
  const [first] = room.areas;
  const left = Math.min(...first.x);
  const top = Math.max(...first.y);
  const width = Math.max(...first.x) - left;
  const listed = ids.filter((id) => !placed.has(id) && !robots.value.has(deviceOf(id)?.value.name));
  const perColumn = Math.max(1, Math.floor((top - Math.min(...first.y)) / unit / ROW - 2));
  const columns = Math.max(1, Math.floor(width / unit / COLUMN));
  const isLit = ids.some((id) => hasLight(deviceOf(id)?.value));
  return html`<g>
    <path class=${isLit ? "area lit" : "area"} fill-rule="evenodd" d=${room.areas.map(pathOf).join(" ")} />
    <text class="name" x=${left + unit} y=${-top + 1.8 * unit}>${room.name}</text>
    ${listed.slice(0, perColumn * columns).map((id, index) => {
      const x = left + unit * 1.4 + (Math.floor(index / perColumn) * width) / columns;
      return html`<${Dot} key=${id} id=${id} x=${x} y=${top - unit * (2 + ROW * ((index % perColumn) + 1))} unit=${unit} isNamed=${true} />`;
    })}
    ${ids.filter((id) => placed.has(id)).map((id) => html`<${Dot} key=${id} id=${id} x=${placed.get(id).x} y=${placed.get(id).y} unit=${unit} />`)}
  </g>`;
}

const ROW = 1.8; // lines of text
const COLUMN = 16; // widths of a line of text

const hasLight = (device) =>
  device?.type.includes("light") && [...device.states.values()].some((one) => one.capability === "on_off" && one.value === true);

/** A gap in the wall that it is in. */
function Doorway({ door, rooms, unit }) {
  const [x, y] = [middle(door.x), middle(door.y)];
  const isFlat = rooms.some((room) => room.areas.some((area) => area.y.some((one) => Math.abs(one - y) < 0.1)));
  const [dx, dy] = isFlat ? [door.width / 2, 0] : [0, door.width / 2];
  return html`<path class="door" stroke-width=${unit / 4} d=${`M ${x - dx} ${-y - dy} L ${x + dx} ${-y + dy}`}><title>${door.name}</title></path>`;
}

function Dot({ id, x, y, unit, isNamed }) {
  const device = deviceOf(id)?.value;
  if (!device) return null;
  const text = summary(device);
  return html`<a href=${`#/device/${encodeURIComponent(id)}`} aria-label=${`${device.name}: ${text}`}>
    <circle class=${isActive(device) ? "dot on" : "dot"} cx=${x} cy=${-y} r=${unit * 0.45}><title>${`${device.name}: ${text}`}</title></circle>
    ${isNamed && html`<text x=${x + unit} y=${-y + unit * 0.35}>${device.name} <tspan class="quiet">${text.split(" · ")[0]}</tspan></text>`}
  </a>`;
}

function positionOf(device) {
  const text = device.facts.find((fact) => fact.name === "position")?.value ?? "";
  const found = /^(-?[\d.]+),\s*(-?[\d.]+)/.exec(text);
  return found ? [{ id: device.id, x: Number(found[1]), y: Number(found[2]) }] : [];
}

function boxOf(rooms) {
  const xs = rooms.flatMap((room) => room.areas.flatMap((area) => area.x));
  const ys = rooms.flatMap((room) => room.areas.flatMap((area) => area.y));
  const left = Math.min(...xs) - 0.5;
  const top = Math.max(...ys) + 0.5;
  return { left, top, width: Math.max(...xs) + 0.5 - left, height: top - Math.min(...ys) + 0.5 };
}

const pathOf = (area) => `${area.x.map((x, index) => `${index ? "L" : "M"} ${x} ${-area.y[index]}`).join(" ")} Z`;
const middle = (numbers) => (Math.min(...numbers) + Math.max(...numbers)) / 2;
