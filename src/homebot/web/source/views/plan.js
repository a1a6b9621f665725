// The plan of the home, with its devices and robots, where places have geometry.
import { computed, signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { call, subscribe } from "../door.js";
import { deviceOf, isHidden, rooms as devicesOf } from "../house.js";
import { html } from "../html.js";
import { say } from "../language.js";
import { useOpen } from "../opened.js";
import { openSheet } from "../tile.js";
import { isActive, summary, titled } from "../words.js";

const robots = signal(new Map()); // by name: the pose
/** One text, so that a pose draws no room anew. */
const robotNames = computed(() => [...robots.value.keys()].join("\n"));

/** Whether the window is that of a phone: a wide plan is turned then, and a small room has dots without names. */
const narrow = matchMedia("(max-width: 37rem)");
const isNarrow = signal(narrow.matches);
narrow.addEventListener("change", () => (isNarrow.value = narrow.matches));

export function Plan() {
  const [places, setPlaces] = useState(null);
  const [floor, setFloor] = useState(null);
  useOpen(() => void call("/discovery/places").then(setPlaces, () => {}));
  useEffect(() => subscribe("/robots/poses", (pose) => (robots.value = new Map(robots.value).set(pose.robot, pose))), []);
  if (!places) return html`<p class="empty">${say("Asking homebot for the plan …")}</p>`;
  const drawn = places.rooms.filter((room) => room.areas.length);
  if (!drawn.length)
    return html`<p class="empty">${say("No room has a shape yet. Give it corners in the table [places.rooms], or import a map: homebot places import FILE.")}</p>`;
  const floors = [...new Set(drawn.map((room) => room.floor))];
  const shown = floor ?? floors[0];
  const upright = drawn.filter((room) => room.floor === shown);
  const [{ width, height }, ring] = [boxOf(upright), (one) => ({ ...one, x: one.y, y: one.x.map((x) => -x) })];
  const isTurned = isNarrow.value && width > height;
  const rooms = isTurned ? upright.map((room) => ({ ...room, areas: room.areas.map(ring) })) : upright;
  const doors = isTurned ? places.doors.map(ring) : places.doors;
  const box = boxOf(rooms);
  const unit = isNarrow.value ? box.width / 28 : Math.max(box.width, box.height) / 72; // the size of text
  const names = new Set(rooms.map((room) => room.name));
  const inside = new Map(devicesOf.value);
  const idsIn = (room) => (inside.get(room.name) ?? []).filter((id) => !isHidden(id));
  return html`<section>
    ${floors.length > 1 && html`<p class="choices">${floors.map((one) => html`<button key=${one} type="button" aria-pressed=${one === shown} onClick=${() => setFloor(one)}>${one || say("Ground")}</button>`)}</p>`}
    <div class="scroll" role="region" tabindex="0" aria-label=${say("plan")}>
      <svg class="plan" viewBox=${`${box.left} ${-box.top} ${box.width} ${box.height}`} font-size=${unit} stroke-width=${unit / 9} role="group" aria-label=${say(rooms.length === 1 ? "plan with {count} room" : "plan with {count} rooms", { count: rooms.length })}>
        ${rooms.map((room) => html`<${Floor} key=${room.name} room=${room} ids=${idsIn(room)} />`)}
        ${doors.filter((door) => door.rooms.some((one) => names.has(one))).map((door) => html`<${Doorway} key=${door.name} door=${door} rooms=${rooms} unit=${unit} />`)}
        <${Robots} unit=${unit} floor=${floors.length < 2 ? null : shown} isTurned=${isTurned} />
        ${rooms.map((room) => html`<${Room} key=${room.name} room=${room} unit=${unit} ids=${idsIn(room)} isTurned=${isTurned} />`)}
      </svg>
    </div>
    <p class="legend">${say("A full dot is on, open or occupied.")} <${Whereabouts} /></p>
  </section>`;
}

/** The robots of a floor; of all with null. */
function Robots({ unit, floor, isTurned }) {
  const here = [...robots.value.values()].filter((pose) => pose.has_position && pose.counts && (floor === null || pose.floor === floor));
  return here.map((pose) => html`<g key=${pose.robot} class="robot" transform=${`translate(${pointOf([pose.x, pose.y], isTurned)}) scale(${unit})`}>
    <title>${pose.robot}</title>
    <circle r="1" />
    <path transform=${`rotate(${(-pose.yaw * 180) / Math.PI + (isTurned ? 90 : 0)})`} d="M 0.65 0 L -0.35 0.45 L -0.35 -0.45 Z" />
    ${here.length > 1 && html`<text y="2.2">${pose.robot}</text>`}
  </g>`);
}

const Whereabouts = () =>
  [...robots.value.values()].map((pose) => `${pose.robot}: ${pose.counts ? pose.room || say("outside of all rooms") : say("not known now")}.`).join(" ");

/** The ground and the walls of a room, below doors, robots and texts. */
function Floor({ room, ids }) {
  const isBright = ids.some((id) => isLit(deviceOf(id)?.value));
  return html`<path class=${isBright ? "area lit" : "area"} fill-rule="evenodd" d=${room.areas.map(pathOf).join(" ")} />`;
}

/** The name of a room, and its devices: at their positions, else in a list. */
function Room({ room, unit, ids, isTurned }) {
  const [first] = room.areas;
  const left = Math.min(...first.x);
  const top = Math.max(...first.y);
  const width = Math.max(...first.x) - left;
  const devices = ids.map((id) => deviceOf(id)?.value).filter((one) => one && !robotNames.value.split("\n").includes(one.name));
  const placed = devices.filter((one) => one.position.length);
  const listed = devices.filter((one) => !one.position.length);
  const isNamed = !isNarrow.value || width > 9 * unit;
  const [begin, rowHeight, columnWidth] = isNamed ? [3.8, 1.8, 16] : [3.2, 2, 2]; // in heights of a line of text
  const perColumn = Math.max(1, Math.floor(((top - Math.min(...first.y)) / unit - begin - 0.6) / rowHeight) + 1);
  const columns = Math.max(1, Math.floor(width / unit / columnWidth));
  const most = perColumn * columns;
  const shown = listed.slice(0, most < listed.length ? most - 1 : most); // the last place says how many more there are
  const placeOf = (index) => [left + unit * 1.4 + (Math.floor(index / perColumn) * width) / columns, -top + unit * (begin + rowHeight * (index % perColumn))];
  const more = placeOf(shown.length);
  return html`<g>
    <a href=${`#/room/${encodeURIComponent(room.name)}`}><text class="name" font-size=${Math.min(unit, width / room.name.length)} x=${left + unit * 0.8} y=${-top + 1.6 * unit}>${titled(room.name)}</text></a>
    ${shown.map((device, index) => html`<${Dot} key=${device.id} device=${device} at=${placeOf(index)} unit=${unit} most=${isNamed ? width / columns / unit : 0} />`)}
    ${shown.length < listed.length && html`<text x=${more[0] - unit * 0.4} y=${more[1] + unit * 0.35}>+${listed.length - shown.length}</text>`}
    ${placed.map((device) => html`<${Dot} key=${device.id} device=${device} at=${pointOf(device.position, isTurned)} unit=${unit} most=${0} />`)}
  </g>`;
}

const isLit = (device) =>
  device?.type.includes("light") && [...device.states.values()].some((one) => one.capability === "on_off" && one.value === true);

/** A gap in the wall that it is in. */
function Doorway({ door, rooms, unit }) {
  const [x, y] = [middle(door.x), middle(door.y)];
  const isFlat = rooms.some((room) => room.areas.some((area) => area.y.some((one) => Math.abs(one - y) < 0.1)));
  const [dx, dy] = isFlat ? [door.width / 2, 0] : [0, door.width / 2];
  return html`<path class="door" stroke-width=${unit / 4} d=${`M ${x - dx} ${-y - dy} L ${x + dx} ${-y + dy}`}><title>${door.name}</title></path>`;
}

/** A device, with its name and, if they are no wider than `most` heights of a line, its state. */
function Dot({ device, at: [x, y], unit, most }) {
  const text = summary(device);
  const [state] = text.split(" · ");
  const open = (event) => {
    event.preventDefault();
    openSheet(device.id);
  };
  return html`<a href=${`#/device/${encodeURIComponent(device.id)}`} onClick=${open} aria-label=${`${device.name}: ${text}`}>
    <circle class=${isActive(device) ? "dot on" : "dot"} cx=${x} cy=${y} r=${unit * (most ? 0.45 : 0.7)}><title>${`${device.name}: ${text}`}</title></circle>
    ${most > 0 && html`<text x=${x + unit} y=${y + unit * 0.35}>${cut(device.name, most)} ${widthOf(device.name + state) < most && html`<tspan class="quiet">${state}</tspan>`}</text>`}
  </a>`;
}

/** The width of a name behind its dot, in heights of a line, and a name that is no wider than that. */
const widthOf = (name) => name.length * 0.55 + 3;
const cut = (name, most) => (widthOf(name) < most ? name : `${name.slice(0, Math.floor((most - 3) / 0.55))}…`);

/** A point of the house in the picture. */
const pointOf = ([x, y], isTurned) => (isTurned ? [y, x] : [x, -y]);

function boxOf(rooms) {
  const xs = rooms.flatMap((room) => room.areas.flatMap((area) => area.x));
  const ys = rooms.flatMap((room) => room.areas.flatMap((area) => area.y));
  const left = Math.min(...xs) - 0.5;
  const top = Math.max(...ys) + 0.5;
  return { left, top, width: Math.max(...xs) + 0.5 - left, height: top - Math.min(...ys) + 0.5 };
}

const pathOf = (area) => `${area.x.map((x, index) => `${index ? "L" : "M"} ${x} ${-area.y[index]}`).join(" ")} Z`;
const middle = (numbers) => (Math.min(...numbers) + Math.max(...numbers)) / 2;
