// The page: its header, the view that the address names, the token, and the outcome of the last command.
import { effect, signal } from "@preact/signals";
import { render } from "preact";
import { agreement, outcome } from "./acting.js";
import { connect, connection, logIn, logOut, missing, token } from "./door.js";
import { count, follow, isLoaded, nameOf } from "./house.js";
import { html } from "./html.js";
import { LANGUAGES, choose, language, say } from "./language.js";
import { Agreement, Questions } from "./questions.js";
import { Device } from "./views/device.js";
import { Graph } from "./views/graph.js";
import { House, Room } from "./views/house.js";
import { Journal } from "./views/journal.js";
import { Plan } from "./views/plan.js";
import { Rates } from "./views/rates.js";
import { Routines } from "./views/routines.js";
import { System } from "./views/system.js";
import { loadVocabulary, titled } from "./words.js";

const VIEWS = {
  house: ["House", House],
  plan: ["Plan", Plan],
  routines: ["Routines", Routines],
  journal: ["Journal", Journal],
  system: ["System", System],
};

/** Views to which others lead; without a title, of one thing that the address names. */
const BELOW = {
  device: ["", Device, "house"],
  room: ["", Room, "house"],
  graph: ["Graph", Graph, "system"],
  rates: ["Rates", Rates, "system"],
};

/** The last house or room that was looked at, where an installed page begins: of a tablet at the wall, its room. */
const START = "homebot.start";

if (!location.hash && location.search === "?installed") history.replaceState(null, "", `#/${localStorage.getItem(START) ?? ""}`);

const place = signal(placeNow());
const isLoggingIn = signal(false);

function placeNow() {
  const [, view = "house", id = ""] = location.hash.split("/");
  try {
    return { view: view || "house", id: decodeURIComponent(id) };
  } catch {
    return { view, id }; // a bare % in an address that was typed in
  }
}

function Page() {
  const { view, id } = place.value;
  const { state, reason, home } = connection.value;
  const mustLogIn = state === "refused";
  const [title, View, above = view] = VIEWS[view] ?? BELOW[view] ?? [];
  return html`
    <header>
      <h1>${home || "homebot"}</h1>
      <nav aria-label=${say("views")}>
        ${Object.entries(VIEWS).map(([name, [text]]) => html`<a key=${name} href=${`#/${name}`} aria-current=${name === above ? "page" : undefined}>${say(text)}</a>`)}
      </nav>
      <p role="status" class=${state === "open" ? "" : "bad"}>
        ${state === "open" ? say(count.value === 1 ? "{count} device" : "{count} devices", { count: count.value }) : say(mustLogIn ? "not logged in" : reason || "connecting …")}
      </p>
      ${token.value && !mustLogIn
        ? html`<button type="button" onClick=${logOut}>${say("log out")}</button>`
        : html`<button type="button" aria-expanded=${isLoggingIn.value} onClick=${() => (isLoggingIn.value = !isLoggingIn.value)}>${say("log in")}</button>`}
    </header>
    ${(mustLogIn || isLoggingIn.value || missing.value) && html`<${LogIn} reason=${mustLogIn ? reason : missing.value} />`}
    <${Questions} />
    <main class=${state === "open" ? "" : "old"}>${View ? html`<${View} key=${title || id} id=${id} />` : html`<p class="empty">${say("There is no such view.")}</p>`}</main>
    <${Agreement} />
    <p role="alert" class=${outcome.value ? `outcome ${outcome.value.isGood ? "good" : "bad"}` : "hidden"}>
      ${outcome.value?.text} ${outcome.value?.override && html`<button type="button" onClick=${outcome.value.override}>${say("Command it all the same?")}</button>`} ${outcome.value && !outcome.value.isGood && html`<button type="button" onClick=${() => (outcome.value = null)}>${say("close|do")}</button>`}
    </p>
    <footer><label>${say("Language")} <select onChange=${(event) => choose(event.target.value)}>${Object.entries(LANGUAGES).map(([name, text]) => html`<option key=${name} value=${name} lang=${name} selected=${name === language.value}>${text}</option>`)}</select></label></footer>`;
}

function LogIn({ reason }) {
  const submit = (event) => {
    event.preventDefault();
    const given = new FormData(event.target);
    isLoggingIn.value = false;
    logIn(given.get("token").trim(), given.get("remember") === "on");
  };
  return html`<form class="box fields" aria-label=${say("log in")} onSubmit=${submit}>
    ${reason && html`<p class="bad">${reason}</p>`}
    <p>${say("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${say("Token")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label><input type="checkbox" name="remember" /> ${say("keep it in this browser")}</label>
    <p class="buttons"><button>${say("log in")}</button> ${reason && token.value && html`<button type="button" onClick=${logOut}>${say("go on without a token")}</button>`} ${missing.value && html`<button type="button" onClick=${() => (missing.value = "")}>${say("not now")}</button>`}</p>
  </form>`;
}

addEventListener("hashchange", () => {
  place.value = placeNow();
  outcome.value = null; // it is of the view before
  agreement.value = null;
  document.querySelector("main")?.scrollTo?.(0, 0);
  scrollTo(0, 0);
});
effect(() => {
  const { view, id } = place.value;
  if (view === "house" || view === "room") localStorage.setItem(START, `${view}/${encodeURIComponent(id)}`);
});
effect(() => {
  const { view, id } = place.value;
  const shown = view === "device" ? isLoaded.value && nameOf(id) : view === "room" ? titled(id) : say((VIEWS[view] ?? BELOW[view])?.[0] ?? "");
  document.title = [shown, connection.value.home || "homebot"].filter(Boolean).join(" · ");
});
loadVocabulary();
follow();
connect();
render(html`<${Page} />`, document.getElementById("page"));
