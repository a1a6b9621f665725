// The lights that are on, and all off with one touch; then the others.
import { computed } from "@preact/signals";
import { may } from "../door.js";
import { deviceOf, shown } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { say } from "../language.js";
import { isLightOn } from "../summaries.js";
import { Tile } from "../tile.js";
import { toggleLights } from "./home.js";

/** The ids of those that are on, and of the others, as a text: a new level changes it not, and draws one tile. */
const order = computed(() => {
  const lights = shown.value.filter((one) => one.type === "light");
  return JSON.stringify([true, false].map((isOn) => lights.filter((one) => isLightOn(one) === isOn).map((one) => one.id)));
});

export function Lights() {
  const [on, off] = JSON.parse(order.value).map((ids) => ids.map((id) => deviceOf(id).peek()));
  return html`
    <header class="top"><h1>${say("Lights")}</h1>
      ${on.length > 0 && may("act") && html`<button type="button" class="pill lit" onClick=${() => toggleLights(on)}><${Sign} path=${SIGNS.lights} /> ${say("{count} on", { count: on.length })} · ${say("all off")}</button>`}</header>
    ${[[say("on"), on], [say("off"), off]].filter(([, found]) => found.length).map(([title, found]) => html`<section key=${title}><h2>${title}</h2><div class="tiles">${found.map((one) => html`<${Tile} key=${one.id} id=${one.id} room=${one.room} />`)}</div></section>`)}`;
}
