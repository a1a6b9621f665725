// What belongs to this screen alone: its language, light or dark, whether it is at a wall, and its token.
import { effect, signal } from "@preact/signals";
import { connection, logOut, token } from "./door.js";
import { isLoggingIn } from "./frame.js";
import { allRooms } from "./summaries.js";
import { titled } from "./words.js";
import { html } from "./html.js";
import { LANGUAGES, choose, language, say } from "./language.js";

const THEME = "homebot.theme";
const THEMES = { "": "as the system", light: "light|theme", dark: "dark|theme" };

const theme = signal(localStorage.getItem(THEME) ?? "");
effect(() => {
  localStorage.setItem(THEME, theme.value);
  document.documentElement.dataset.theme = theme.value;
});

const WALL = "homebot.wall";
const asked = new URLSearchParams(location.search).get("wall"); // a kiosk's address

/** The room of a screen at a wall, "home" for Home; empty for a screen at none. */
export const wall = signal(asked === null ? (localStorage.getItem(WALL) ?? "") : asked === "off" ? "" : asked || "home");
effect(() => localStorage.setItem(WALL, wall.value));

/** The address of the first view of a screen. */
export const startOf = (room) => (room && room !== "home" ? `#/room/${encodeURIComponent(room)}` : "#/home");

export function Screen() {
  const isIn = token.value && connection.value.state !== "refused";
  return html`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${say("This screen")}</h2>
    <label><span>${say("Language")}</span> <select name="language" onChange=${(event) => choose(event.target.value)}>${Object.entries(LANGUAGES).map(([name, text]) => html`<option key=${name} value=${name} lang=${name} selected=${name === language.value}>${text}</option>`)}</select></label>
    <label><span>${say("Colors")}</span> <select name="theme" onChange=${(event) => (theme.value = event.target.value)}>${Object.entries(THEMES).map(([name, text]) => html`<option key=${name} value=${name} selected=${name === theme.value}>${say(text)}</option>`)}</select></label>
    <label><span>${say("At a wall")}</span> <select name="wall" onChange=${(event) => (wall.value = event.target.value)}>${[["", say("no")], ["home", say("begins with {view}", { view: say("Home") })], ...allRooms.value.filter(([room]) => room).map(([room]) => [room, say("begins with {view}", { view: titled(room) })])].map(([room, text]) => html`<option key=${room} value=${room} selected=${room === wall.value}>${text}</option>`)}</select></label>
    ${wall.value && html`<p class="legend">${say("After five minutes it shows a dim clock and what is open. The address of this screen:")} <code>${`${location.origin}/?wall=${encodeURIComponent(wall.value)}`}</code></p>`}
    <p class="choices">${isIn ? html`<button type="button" onClick=${logOut}>${say("log out")}</button>` : html`<button type="button" aria-expanded=${isLoggingIn.value} onClick=${() => (isLoggingIn.value = !isLoggingIn.value)}>${say("log in")}</button>`}</p>
  </section>`;
}
