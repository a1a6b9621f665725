// What is asked of this screen alone: its language, light or dark, whether it is at a wall, and its token.
import { EXPIRED, connection, logIn, logOut, missing, token } from "../door.js";
import { isLoggingIn } from "../frame.js";
import { html, written } from "../html.js";
import { LANGUAGES, choose, language, say } from "../language.js";
import { theme, wall } from "../screen.js";
import { allRooms } from "../summaries.js";
import { titled } from "../words.js";

const THEMES = { "": "as the system", light: "light|theme", dark: "dark|theme" };

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

export function LogIn({ reason }) {
  const submit = (event) => {
    const given = written(event);
    isLoggingIn.value = false;
    logIn(given.get("token").trim(), given.get("remember") === "on");
  };
  return html`<form class="card fields" aria-label=${say("log in")} onSubmit=${submit}>
    ${reason && html`<p class="bad">${say(reason)}</p>`}
    <p>${say("The code that homebot run prints lets a first screen in.")}</p>
    <p>${say("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${say("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${say("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${say("log in")}</button> ${reason && (token.value || reason === EXPIRED) && html`<button type="button" onClick=${logOut}>${say("go on without a token")}</button>`} ${missing.value && html`<button type="button" onClick=${() => (missing.value = "")}>${say("not now")}</button>`}</p>
  </form>`;
}
