// The screen at a wall: back to its first view after two minutes; after five a dim clock with what is open, which a touch,
// an alert, the doorbell or motion in its room ends; darker by night.
import { computed, effect, signal } from "@preact/signals";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import { urgent } from "./added.js";
import { now, zone } from "./clock.js";
import { call, connection, onOpen, subscribe } from "./door.js";
import { deviceOf, shown } from "./house.js";
import { html } from "./html.js";
import { SIGNS, Sign, thingOf } from "./icons.js";
import { say } from "./language.js";
import { untouched } from "./layout.js";
import { startOf, wall } from "./screen.js";
import { isLightOn, openOf, openText } from "./summaries.js";
import { closeSheet, openSheet, sheet } from "./tile.js";
import { hour } from "./words.js";

const BACK = 120_000; // ms without a touch
const REST = 300_000;
const DEAF = 350; // ms in which the touch that woke it may still end
const MOST = 6; // open things that are named
const DUSK = -0.105; // sine of the height of the sun, 6° below the horizon
const [EVENING, MORNING] = [22, 6]; // hours of the night where the place is unknown
const SHIFT = 24; // px

const rests = signal(false);
const minute = signal(0);
const place = signal([]);
let wokenAt = -Infinity; // by something else than a touch

const calm = () => Math.min(untouched(), performance.now() - Math.max(wokenAt, 0));
const isDanger = () => urgent().some((one) => one.urgency === "danger");

function wake() {
  wokenAt = performance.now();
  rests.value = false;
}

/** Whether it is dark outside; the sun's own unevenness of a quarter of an hour does not matter. */
const isNight = computed(() => {
  const at = 60 * minute.value;
  if (place.value.length < 2) {
    const own = Number(new Intl.DateTimeFormat("en", { hour: "numeric", hourCycle: "h23", timeZone: zone.value }).format(1000 * at));
    return own >= EVENING || own < MORNING;
  }
  const [latitude, longitude] = place.value.map((one) => (one * Math.PI) / 180);
  const tilt = -0.4091 * Math.cos((2 * Math.PI * (at / 86_400 + 10)) / 365.25);
  const turn = (2 * Math.PI * at) / 86_400 + longitude - Math.PI;
  return Math.sin(latitude) * Math.sin(tilt) + Math.cos(latitude) * Math.cos(tilt) * Math.cos(turn) < DUSK;
});

/** What rings, or moves in the room of this screen. */
function notice({ device: id, readings }) {
  const device = deviceOf(id)?.peek();
  if (!device) return;
  const rings = readings.some((one) => one.capability === "press") && /bell|klingel|sonnette|timbre|campanello/i.test(`${device.name} ${thingOf(device)}`);
  const moves = readings.some((one) => one.capability === "occupancy" && one.value === true) && device.room.toLowerCase() === wall.peek().toLowerCase();
  if (rings || moves) wake();
  if (rings && device.type === "camera" && !sheet.peek()) openSheet(id);
}

/** Live as a screen at the wall; returns the function that ends it. */
function begin() {
  let isOn = true;
  let lock = null; // keeps the screen awake, where the browser allows it, until the page is hidden
  const seen = async () => {
    if (!document.hidden) lock = await navigator.wakeLock?.request("screen").catch(() => null);
    if (!isOn) lock?.release();
  };
  const look = () => {
    minute.value = Math.floor(now() / 60);
    if (calm() > BACK) {
      if (sheet.peek()) closeSheet();
      else if (location.hash !== startOf(wall.peek())) location.hash = startOf(wall.peek());
    }
    rests.value = calm() > REST && !isDanger();
  };
  const known = new Set();
  const ends = [
    subscribe("/discovery/states", notice),
    onOpen(() => call("/homebot/place").then((answer) => (place.value = answer.place), () => {})),
    effect(() => {
      const found = urgent().flatMap((one) => one.rows.map((row) => `${one.code} ${row.what}`));
      if (found.some((one) => !known.has(one))) wake();
      known.clear();
      for (const one of found) known.add(one);
    }),
  ];
  const timer = setInterval(look, 1000);
  const menu = (event) => event.preventDefault();
  document.documentElement.classList.add("wall");
  addEventListener("contextmenu", menu);
  document.addEventListener("visibilitychange", seen);
  seen();
  look();
  return () => {
    isOn = rests.value = false;
    lock?.release();
    clearInterval(timer);
    for (const end of ends) end();
    document.documentElement.classList.remove("wall");
    removeEventListener("contextmenu", menu);
    document.removeEventListener("visibilitychange", seen);
  };
}

export function Wall() {
  useEffect(begin, [wall.value]);
  return html`${rests.value && html`<${Rest} />`}${isNight.value && !rests.value && !urgent().length && html`<div class="night"></div>`}`;
}

function Rest() {
  const box = useRef(null);
  useLayoutEffect(() => {
    const held = document.activeElement;
    box.current.focus();
    const onKey = (event) => {
      event.preventDefault();
      event.stopPropagation();
      wake();
    };
    addEventListener("keydown", onKey, true);
    return () => {
      removeEventListener("keydown", onKey, true);
      held?.focus();
    };
  }, []);
  const later = () => setTimeout(wake, DEAF);
  const open = openOf(shown.value);
  const lights = shown.value.filter((one) => one.type === "light" && isLightOn(one)).length;
  const shift = (step) => `${((minute.value * step) % (2 * SHIFT)) - SHIFT}px`;
  return html`<div class="wallclock" ref=${box} tabindex="-1" role="dialog" aria-modal="true" aria-label=${say("at rest")} onPointerUp=${later} onPointerCancel=${later}>
    <div style=${{ translate: `${shift(7)} ${shift(11)}` }}>
      <p class="hours"><time>${hour.value.format(60_000 * minute.value)}</time></p>
      ${connection.value.state !== "open" && html`<p>${say("homebot cannot be reached")}</p>`}
      ${urgent().map((one) => html`<p key=${one.code} class="warm"><${Sign} path=${SIGNS.alert} size=${30} /> <span>${say(one.title || "problem")}</span></p>`)}
      ${open.slice(0, MOST).map((one) => html`<p key=${one.id} class="warm"><${Sign} path=${SIGNS[thingOf(one)] ?? SIGNS.lock} size=${30} /> <span>${openText([one])}</span></p>`)}
      ${open.length > MOST && html`<p class="warm"><span>+${open.length - MOST}</span></p>`}
      ${lights > 0 && html`<p><${Sign} path=${SIGNS.bulb} size=${30} /> <span>${say("{count} on", { count: lights })}</span></p>`}
    </div>
  </div>`;
}
