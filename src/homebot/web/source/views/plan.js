// The plan of the home, with its devices and robots, where places have geometry.
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { call, connection, subscribe } from "../door.js";
import { deviceOf } from "../house.js";
import { html } from "../html.js";
import { summary } from "../words.js";

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
  const names = new Set(rooms.map((room) => room.name));
  return html`
    ${floors.length > 1 && html`<p class="choices">${floors.map((one) => html`<button key=${one} type="button" aria-pressed=${one === shown} onClick=${() => setFloor(one)}>${one || "Ground"}</button>`)}</p>`}
    <svg class="plan" viewBox=${`${box.left} ${-box.top} ${box.width} ${box.height}`} role="group" aria-label=${`plan with ${rooms.length} rooms`}>
      ${rooms.map((room) => html`<g key=${room.name}>
        <path class="area" fill-rule="evenodd" d=${room.areas.map(pathOf).join(" ")} />
        <text x=${middle(room.areas[0].x)} y=${-Math.max(...room.areas[0].y) + 0.4}>${room.name}</text>
      </g>`)}
      ${places.doors.filter((door) => door.rooms.some((one) => names.has(one))).map((door) => html`<circle key=${door.name} class="door" cx=${middle(door.x)} cy=${-middle(door.y)} r=${door.width / 2}><title>${door.name}</title></circle>`)}
      ${positions.filter((one) => names.has(deviceOf(one.id)?.value.room)).map((one) => html`<${Dot} key=${one.id} ...${one} />`)}
      ${here.map((pose) => html`<g key=${pose.robot} class="robot" transform=${`translate(${pose.x} ${-pose.y}) rotate(${(-pose.yaw * 180) / Math.PI})`}>
        <title>${pose.robot}</title>
        <path d="M 0.35 0 L -0.25 0.25 L -0.25 -0.25 Z" />
      </g>`)}
    </svg>
    <ul class="legend">
      ${[...robots.value.values()].map((pose) => html`<li key=${pose.robot}>${pose.robot}: ${pose.counts ? pose.room || "somewhere" : "not known now"}</li>`)}
    </ul>`;
}

function Dot({ id, x, y }) {
  const device = deviceOf(id)?.value;
  if (!device) return null;
  const isOn = [...device.states.values()].some((one) => one.capability === "on_off" && one.value === true);
  return html`<a href=${`#/device/${encodeURIComponent(id)}`} aria-label=${device.name}>
    <circle class=${isOn ? "dot on" : "dot"} cx=${x} cy=${-y} r="0.13"><title>${`${device.name}: ${summary(device)}`}</title></circle>
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
