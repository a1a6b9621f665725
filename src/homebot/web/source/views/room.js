// A room: its lights, then climate, covers, media and doors as cards, sensors, and what happened there lately.
import { useState } from "preact/hooks";
import { Added } from "../added.js";
import { may } from "../door.js";
import { isLoaded } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { isAside, kindOf, signOf, stateOf, toneOf } from "../kinds.js";
import { say } from "../language.js";
import { second } from "../later.js";
import { LastKnown } from "../marks.js";
import { airOf, allRooms, isLightOn, roomList, temperatureText } from "../summaries.js";
import { Tile, openSheet } from "../tile.js";
import { titled, valueText } from "../words.js";
import { toggleLights } from "./home.js";

const CARDS = ["climate", "covers", "media"];
const Lately = second("Lately");

export function Room({ id }) {
  const [showsAll, setShowsAll] = useState(false);
  const [room, devices] = allRooms.value.find(([name]) => name.toLowerCase() === id.toLowerCase()) ?? [];
  if (!isLoaded.value) return html`<p class="empty">${say("Asking homebot for its devices …")}</p>`;
  const own = devices ?? [];
  const group = (name) => own.filter((one) => kindOf(one).group === name);
  const lights = group("lights");
  const on = lights.filter(isLightOn).length;
  const aside = own.filter(isAside);
  const rest = [...group("doors"), ...group("others").filter((one) => !isAside(one))];
  const [warm, humidity] = [airOf(own), airOf(own, ["humidity"])];
  return html`
    <${Added} at="top" />
    <header class="top">
      <a class="round back" href="#/home" aria-label=${say("Home")}><${Sign} path=${SIGNS.left} size=${28} /></a>
      <h1><bdi>${id ? titled(id) : say("Without a room")}</bdi></h1>
      <p class="air">${warm !== undefined && html`<span><${Sign} path=${SIGNS.climate} size=${22} /> ${temperatureText(warm)}</span>`} ${humidity !== undefined && html`<span><${Sign} path=${SIGNS.humidity} size=${22} /> ${valueText("humidity", Math.round(humidity))}</span>`}</p>
      ${lights.length > 0 && may("act") && html`<button type="button" class=${on ? "pill lit" : "pill"} onClick=${() => toggleLights(lights)}><${Sign} path=${on ? SIGNS.lights : SIGNS.bulbOff} /> ${on ? `${say("{count} on", { count: on })} · ${say("all off")}` : say("all on")}</button>`}
    </header>
    <nav class="tabs" aria-label=${say("rooms")}>${roomList.value.map(([name]) => html`<a key=${name} href=${`#/room/${encodeURIComponent(name)}`} aria-current=${name.toLowerCase() === id.toLowerCase() ? "page" : undefined}>${name ? titled(name) : say("Without a room")}</a>`)}</nav>
    <${Added} at="scenes" room=${id} />
    ${!devices && html`<p class="empty">${say("There is no device in a room {room}.", { room: id })}</p>`}
    <div class="roomgrid">
      ${lights.length > 0 && html`<section class="all" aria-labelledby="lights"><h2 id="lights">${say("Lights")}</h2><${Tiles} devices=${lights} /></section>`}
      ${CARDS.flatMap(group).map((one) => html`<${Card} key=${one.id} device=${one} />`)}
      ${rest.length > 0 && html`<section class=${rest.length > 1 ? "two" : ""} aria-labelledby="others"><h2 id="others">${say("Doors, sensors and others")}</h2><${Tiles} devices=${rest} /></section>`}
      ${devices && html`<${Lately} ids=${own.map((one) => one.id)} isWide=${rest.length < 2} />`}
      ${aside.length > 0 && html`<section class="all">
        <p class="choices"><button type="button" aria-expanded=${showsAll} onClick=${() => setShowsAll(!showsAll)}>${say("buttons, settings and updates: {count}", { count: aside.length })}</button></p>
        ${showsAll && html`<${Tiles} devices=${aside} />`}
      </section>`}
    </div>
    <${LastKnown} />`;
}

export const Tiles = ({ devices }) => html`<div class="tiles">${devices.map((one) => html`<${Tile} key=${one.id} id=${one.id} />`)}</div>`;

/** A device with its main control, large enough for a hand in passing. */
function Card({ device }) {
  const { Main } = kindOf(device);
  return html`<section class="card" aria-label=${device.name}>
    <h2><span class=${`icon ${toneOf(device)}`}><${Sign} path=${signOf(device)} /></span> <bdi>${device.name}</bdi> <small>${stateOf(device)}</small>
      <button type="button" class="round more" aria-label=${say("more of {name}", { name: device.name })} onClick=${() => openSheet(device.id)}><${Sign} path=${SIGNS.right} /></button></h2>
    ${device.may_act && html`<${Main} device=${device} />`}
  </section>`;
}
