// The page without homebot, and with a newer one: a worker keeps its files, this tab the house it knew last; and another
// build of homebot loads the page anew, but not under a finger.
import { effect } from "@preact/signals";
import { connection } from "./door.js";
import { isLoaded } from "./house.js";
import { LANGUAGES, language } from "./language.js";
import { untouched } from "./layout.js";

const BUILD = document.querySelector("meta[name=build]").content;
const RENEWED = "homebot.renewed";
const CALM = 60_000; // ms without a touch after which the page may be loaded anew
const PATIENCE = 10_000; // ms in which a newer worker takes over

const workers = navigator.serviceWorker; // only where the browser trusts the connection
const createScriptURL = (name) => `worker.js?${name in LANGUAGES ? name : "en"}`;
const policy = globalThis.trustedTypes?.createPolicy("worker", { createScriptURL }) ?? { createScriptURL };

effect(() => {
  const name = language.value;
  if (isLoaded.value && connection.value.state === "open") workers?.register(policy.createScriptURL(name)).catch(() => {}); // the page goes on without it
});

let waiting = 0;
effect(() => {
  const { state, build } = connection.value;
  clearTimeout(waiting);
  if (state === "open" && build && build !== BUILD) renew(build);
});

/** Load the page anew once nobody touches it; once for each build, as it may not help. */
function renew(build) {
  if (sessionStorage.getItem(RENEWED) === build) return;
  const left = CALM - untouched();
  if (left > 0) waiting = setTimeout(renew, left, build);
  else {
    sessionStorage.setItem(RENEWED, build);
    takeOver().finally(dropIndex).catch(() => {}).then(() => location.reload());
  }
}

/** Let the worker of the newer build take over; without one the files come from homebot. */
async function takeOver() {
  const own = await workers.getRegistration();
  const late = new Promise((resolve) => setTimeout(resolve, PATIENCE));
  await Promise.race([own.update(), late]).catch(() => {});
  const next = own.installing ?? own.waiting;
  if (next) {
    await Promise.race([late, new Promise((resolve) => {
      next.onstatechange = () => (next.state === "installed" ? next.postMessage("take over") : ["activated", "redundant"].includes(next.state) && resolve());
      next.onstatechange();
    })]);
  }
  if (next?.state !== "activated") await own.unregister();
}

/** Let the old worker, which stays while another tab has it, ask homebot for the page itself. */
async function dropIndex() {
  for (const name of await caches.keys()) if (name.includes(BUILD)) await (await caches.open(name)).delete("./");
}
