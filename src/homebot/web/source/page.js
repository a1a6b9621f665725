// The page: the view that the address names, in its frame.
import { effect, signal } from "@preact/signals";
import { render } from "preact";
import { agreement, outcome } from "./acts.js";
import { VIEWS as ADDED } from "./added.js";
import { connect, connection } from "./door.js";
import { Frame } from "./frame.js";
import { follow, isLoaded, nameOf } from "./house.js";
import { html } from "./html.js";
import { say } from "./language.js";
import { later, second, soon } from "./later.js";
import "./offline.js";
import { startOf, wall } from "./screen.js";
import { sheet } from "./tile.js";
import { Home } from "./views/home.js";
import { loadVocabulary, titled } from "./words.js";

const rail = (name) => later(async () => (await import("./rail.js"))[name]);
const care = (name) => later(async () => (await import("./care.js"))[name]);

/** Each view: its title, its component, the view of the rail that is `above` it, and whether it has a heading of its own; without a title, it is of one thing that the address names. */
const VIEWS = {
  home: { title: "Home", View: Home, hasHead: true },
  security: { title: "Security", View: rail("Security"), hasHead: true },
  climate: { title: "Climate", View: rail("Climate"), hasHead: true },
  lights: { title: "Lights", View: soon("Lights"), above: "home", hasHead: true },
  plan: { title: "Plan", View: rail("Plan") },
  journal: { title: "Journal", View: rail("Journal") },
  system: { title: "System", View: care("System") },
  more: { title: "More", View: second("More"), hasHead: true },
  setup: { title: "Set up", View: care("Setup"), above: "system" },
  device: { title: "", View: rail("Device"), above: "home", hasHead: true },
  room: { title: "", View: soon("Room"), above: "home", hasHead: true },
  graph: { title: "Graph", View: care("Graph"), above: "system" },
  rates: { title: "Rates", View: care("Rates"), above: "system" },
  ...ADDED,
};
/** Addresses of before. */
const OLD = { house: "home" };

/** The last home or room that was looked at, where an installed page begins: of a tablet at the wall, its room. */
const START = "homebot.start";

if (!location.hash && wall.value) history.replaceState(null, "", startOf(wall.value));
else if (!location.hash && location.search === "?installed") history.replaceState(null, "", `#/${localStorage.getItem(START) ?? ""}`);

const place = signal(placeNow());

function placeNow() {
  const [, named = "", id = ""] = location.hash.split("/");
  const view = OLD[named] ?? (named || "home");
  try {
    return { view, id: decodeURIComponent(id) };
  } catch {
    return { view, id }; // a bare % in an address that was typed in
  }
}

function Page() {
  const { view, id } = place.value;
  const { title, View, above = view, hasHead } = VIEWS[view] ?? {};
  return html`<${Frame} above=${above}>${!hasHead && html`<h1>${say(title ?? "homebot")}</h1>`}${View ? html`<${View} key=${title || id} id=${id} />` : html`<p class="empty">${say("There is no such view.")}</p>`}<//>`;
}

addEventListener("hashchange", () => {
  place.value = placeNow();
  sheet.value = ""; // it is of the view before, as these are
  outcome.value = null;
  agreement.value = null;
  scrollTo(0, 0);
});
effect(() => {
  const { view, id } = place.value;
  if (view === "home" || view === "room") localStorage.setItem(START, `${view}/${encodeURIComponent(id)}`);
});
effect(() => {
  const { view, id } = place.value;
  const text = view === "device" ? isLoaded.value && nameOf(id) : view === "room" ? titled(id) : say(VIEWS[view]?.title ?? "");
  document.title = [text, connection.value.home || "homebot"].filter(Boolean).join(" · ");
});
loadVocabulary();
VIEWS[place.value.view]?.View.begin?.().catch(() => {}); // it is asked for again as it is shown
follow();
connect();
render(html`<${Page} />`, document.getElementById("page"));
