// Home: what is urgent, the time and the people, the house in four chips, favorites, scenes, and rooms.
import { computed, signal } from "@preact/signals";
import { useEffect, useLayoutEffect, useState } from "preact/hooks";
import { perform } from "../acts.js";
import { Added } from "../added.js";
import { now, zone } from "../clock.js";
import { connection, may } from "../door.js";
import { count, deviceOf, isHidden, isLoaded, rooms, shown } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign, roomSign, thingOf } from "../icons.js";
import { isAside, kindOf } from "../kinds.js";
import { capital, label as labelOf, hasWords, hour, titled } from "../words.js";
import { locale, say } from "../language.js";
import { later } from "../later.js";
import { askUsage, beginVisit, layout, usage } from "../layout.js";
import { LastKnown } from "../marks.js";
import { airOf, isAtHome, isLightOn, isOutside, openOf, openText, people, roomList, temperatureText } from "../summaries.js";
import { Tile } from "../tile.js";

const MANY = 30; // devices from which on they can be searched
const MOST = 8; // favorites that are filled by use
const GROUPS = ["lights", "climate", "doors", "covers", "media", "others"];

const sought = signal("");
const showsHidden = signal(false);
const hidden = computed(() => rooms.value.flatMap(([, ids]) => ids.filter(isHidden)));
const isEditing = signal(false);
const Edit = later(async () => (await import("./edit.js")).Edit);

/** The favorites of the owner; the places up to eight are filled by use at this time of day, then by what most people use. */
const favorites = computed(() => {
  const { favorites: starred, not_here: never } = layout.value;
  const known = rooms.value.flatMap(([, ids]) => ids.filter((id) => !isHidden(id))).map((id) => deviceOf(id).peek());
  const own = starred.map((id) => known.find((one) => one.id === id)).filter(Boolean);
  const others = known.filter((one) => !own.includes(one) && !never.includes(one.id) && GROUPS.includes(kindOf(one).group) && !isAside(one) && one.settable.length);
  const order = others.sort((a, b) => GROUPS.indexOf(kindOf(a).group) - GROUPS.indexOf(kindOf(b).group));
  const [lamps, rest] = [order.filter((one) => kindOf(one).group === "lights"), order.filter((one) => kindOf(one).group !== "lights")];
  const { total, atThisHour } = usage.value;
  const filled = [...lamps.slice(0, 4), ...rest, ...lamps.slice(4)].map(({ id }) => [atThisHour(id), total(id), id]).sort((a, b) => b[0] - a[0] || b[1] - a[1]);
  return [...own.map((one) => one.id), ...filled.map(([, , id]) => id)].slice(0, Math.max(MOST, own.length));
});

export function Home() {
  const isReady = isLoaded.value;
  useLayoutEffect(() => {
    if (isReady) beginVisit();
    if (isReady) askUsage();
    return () => (isEditing.value = false);
  }, []);
  const isSought = Boolean(sought.value.trim());
  if (!isReady) return html`<p class="empty">${say("Asking homebot for its devices …")}</p>`;
  const ids = favorites.value;
  return html`
    <${Added} at="top" />
    <${Top} />
    <h1 class="hidden">${connection.value.home || say("Home")}</h1>
    ${!count.value && html`<p class="empty">${say("No device is known yet. They appear here as the gateways find them.")}</p>`}
    <${Chips} />
    ${isEditing.value && html`<${Edit} ids=${ids} onDone=${() => (isEditing.value = false)} />`}
    ${!isEditing.value && ids.length > 0 && html`<section class="favorites" aria-labelledby="favorites">
      <div class="head"><h2 id="favorites">${say(isSought ? "Search" : "Favorites")}</h2>${count.value > MANY && html`<label class="search"><${Sign} path=${SIGNS.search} /><span class="hidden">${say("Search")}</span><input type="search" placeholder=${say("Search")} value=${sought.value} onInput=${(event) => (sought.value = event.target.value)} /></label>`}
        ${may("act") && !isSought && html`<button type="button" class="edit" onClick=${() => (isEditing.value = true)}><${Sign} path=${SIGNS.pencil} size=${20} /> ${capital(say("edit"))}</button>`}</div>
      ${isSought ? html`<${Found} />` : html`<${Tiles} ids=${ids} />`}</section>`}
    ${!isSought && !isEditing.value &&
      html`<${Added} at="scenes" />
        <section aria-labelledby="rooms"><h2 id="rooms">${say("Rooms")}</h2><div class="rooms">${roomList.value.map(([room, devices]) => html`<${RoomCard} key=${room} room=${room} devices=${devices} />`)}</div></section>`}
    <${LastKnown} />
    ${!isEditing.value && hidden.value.length > 0 && html`<p class="choices"><button type="button" aria-pressed=${showsHidden.value} onClick=${() => (showsHidden.value = !showsHidden.value)}>${say("show {count} hidden", { count: hidden.value.length })}</button></p>`}
    ${showsHidden.value && html`<${Tiles} ids=${hidden.value} />`}`;
}

const Tiles = ({ ids }) => html`<div class="tiles">${ids.map((id) => html`<${Tile} key=${id} id=${id} room=${deviceOf(id)?.peek().room ?? ""} />`)}</div>`;

function Found() {
  const found = shown.value.filter((one) => hasWords(`${one.name} ${one.given} ${labelOf(one.type)} ${one.room}`, sought.value)).map((one) => one.id);
  return found.length ? html`<${Tiles} ids=${found} />` : html`<p class="empty">${say("No device has these words in its name, type or room.")}</p>`;
}

/** The time at home, the temperature outside, and who is there. */
function Top() {
  const [, setMinute] = useState(0);
  useEffect(() => {
    const timer = setInterval(() => setMinute(Math.floor(now() / 60)), 1000);
    return () => clearInterval(timer);
  }, []);
  const outside = airOf(shown.value.filter(isOutside), ["temperature"]);
  const date = new Intl.DateTimeFormat(locale.value, { weekday: "long", day: "numeric", month: "long", timeZone: zone.value });
  return html`<header class="top">
    <p class="clock"><time>${hour.value.format(now() * 1000)}</time> <span>${date.format(now() * 1000)}</span></p>
    ${outside !== undefined && html`<p class="outside"><${Sign} path=${SIGNS.climate} /> ${temperatureText(outside)}<span class="far"> ${say("outside")}</span></p>`}
    ${people.value.length > 0 && html`<p class="people">${people.value.map((one) => html`<span key=${one.id} class=${isAtHome(one) ? "person" : "person away"}><span aria-hidden="true">${one.name[0]}</span><span class="hidden">${say(isAtHome(one) ? "{name} is at home" : "{name} is away", { name: one.name })}</span></span>`)}</p>`}
  </header>`;
}

function Chip({ view, sign, text, tone = "rest" }) {
  return html`<a class=${`chip ${tone}`} href=${`#/${view}`}><span class="icon"><${Sign} path=${sign} /></span><span class="name">${say(capitalOf(view))}</span><span class="state">${capital(text)}</span></a>`;
}
const capitalOf = (view) => view[0].toUpperCase() + view.slice(1);

function Chips() {
  const devices = shown.value;
  const open = openOf(devices);
  const lights = devices.filter((one) => one.type === "light");
  const on = lights.filter(isLightOn).length;
  const warm = airOf(devices.filter((one) => !isOutside(one)));
  const heats = devices.some((one) => kindOf(one).group === "climate" && kindOf(one).tone(one) === "heat");
  const guards = devices.some((one) => kindOf(one).group === "doors");
  return html`<nav class="chips" aria-label=${say("summary")}>
    ${guards && html`<${Chip} view="security" sign=${open.length ? (SIGNS[thingOf(open[0])] ?? SIGNS.lock) : SIGNS.shield} text=${openText(open)} tone=${open.length ? "open" : "secure"} />`}
    ${lights.length > 0 && html`<${Chip} view="lights" sign=${SIGNS.lights} text=${on ? say("{count} on", { count: on }) : say("all off")} tone=${on ? "lit" : "rest"} />`}
    ${warm !== undefined && html`<${Chip} view="climate" sign=${SIGNS.climate} text=${temperatureText(warm)} tone=${heats ? "heat" : "rest"} />`}
    <${Added} at="chips" devices=${devices} Chip=${Chip} />
  </nav>`;
}

/** Turn the lights of a room off, or on. */
export function toggleLights(lights) {
  const on = lights.some(isLightOn);
  for (const device of lights) if (isLightOn(device) === on) perform(device, { word: on ? "off" : "on", values: [] });
}

function RoomCard({ room, devices }) {
  const lights = devices.filter((one) => one.type === "light");
  const on = lights.filter(isLightOn).length;
  const warm = airOf(devices.filter((one) => !isOutside(one) || devices.every(isOutside)));
  const marks = [...new Set(openOf(devices).map(thingOf))];
  const text = [warm !== undefined && temperatureText(warm), on > 0 && say(on === 1 ? "1 light" : "{count} lights", { count: on }), !on && warm === undefined && say(devices.length === 1 ? "{count} device" : "{count} devices", { count: devices.length })].filter(Boolean).join(" · ");
  return html`<div class="roomcard">
    <a href=${`#/room/${encodeURIComponent(room)}`}><span class="icon"><${Sign} path=${roomSign(room)} size=${26} /></span>
      <span class="name"><bdi>${room ? titled(room) : say("Without a room")}</bdi>${marks.map((thing) => html`<span key=${thing} class="mark open"><${Sign} path=${SIGNS[thing] ?? SIGNS[thing.replace("_door", "")] ?? SIGNS.lock} size=${20} /><span class="hidden">${say("{name} open", { name: labelOf(thing) })}</span></span>`)}</span>
      <span class="state">${text}</span></a>
    ${lights.length > 0 && may("act") && html`<button type="button" class=${on ? "bulb lit" : "bulb"} aria-pressed=${String(on > 0)} aria-label=${say("lights of {room}", { room: room ? titled(room) : say("Without a room") })} onClick=${() => toggleLights(lights)}><${Sign} path=${on ? SIGNS.bulb : SIGNS.bulbOff} size=${26} /></button>`}
  </div>`;
}
