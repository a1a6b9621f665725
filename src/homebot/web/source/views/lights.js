// The lights that are on, and all off with one touch; then the others.
import { may } from "../door.js";
import { shown } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { say } from "../language.js";
import { isLightOn } from "../summaries.js";
import { Tile } from "../tile.js";
import { toggleLights } from "./home.js";

export function Lights() {
  const lights = shown.value.filter((one) => one.type === "light");
  const on = lights.filter(isLightOn);
  return html`
    <header class="top"><h1>${say("Lights")}</h1>
      ${on.length > 0 && may("act") && html`<button type="button" class="pill lit" onClick=${() => toggleLights(lights)}><${Sign} path=${SIGNS.lights} /> ${say("{count} on", { count: on.length })} · ${say("all off")}</button>`}</header>
    ${[[say("on"), on], [say("off"), lights.filter((one) => !isLightOn(one))]].filter(([, found]) => found.length).map(([title, found]) => html`<section key=${title}><h2>${title}</h2><div class="tiles">${found.map((one) => html`<${Tile} key=${one.id} id=${one.id} room=${one.room} />`)}</div></section>`)}`;
}
