// What belongs to this screen alone: its language, light or dark, and its token.
import { effect, signal } from "@preact/signals";
import { connection, logOut, token } from "./door.js";
import { isLoggingIn } from "./frame.js";
import { html } from "./html.js";
import { LANGUAGES, choose, language, say } from "./language.js";

const THEME = "homebot.theme";
const THEMES = { "": "as the system", light: "light|theme", dark: "dark|theme" };

const theme = signal(localStorage.getItem(THEME) ?? "");
effect(() => {
  localStorage.setItem(THEME, theme.value);
  document.documentElement.dataset.theme = theme.value;
});

export function Screen() {
  const isIn = token.value && connection.value.state !== "refused";
  return html`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${say("This screen")}</h2>
    <label><span>${say("Language")}</span> <select name="language" onChange=${(event) => choose(event.target.value)}>${Object.entries(LANGUAGES).map(([name, text]) => html`<option key=${name} value=${name} lang=${name} selected=${name === language.value}>${text}</option>`)}</select></label>
    <label><span>${say("Colors")}</span> <select name="theme" onChange=${(event) => (theme.value = event.target.value)}>${Object.entries(THEMES).map(([name, text]) => html`<option key=${name} value=${name} selected=${name === theme.value}>${say(text)}</option>`)}</select></label>
    <p class="choices">${isIn ? html`<button type="button" onClick=${logOut}>${say("log out")}</button>` : html`<button type="button" aria-expanded=${isLoggingIn.value} onClick=${() => (isLoggingIn.value = !isLoggingIn.value)}>${say("log in")}</button>`}</p>
  </section>`;
}
