// Energy: now, today beside comparable days, seven days, by room, by device, and what no meter of a device counted.
import { useState } from "preact/hooks";
import { now, zone } from "../../clock.js";
import { call } from "../../door.js";
import { deviceOf, read, shown } from "../../house.js";
import { html } from "../../html.js";
import { Sign } from "../../icons.js";
import { signOf } from "../../kinds.js";
import { locale, say } from "../../language.js";
import { useOpen } from "../../opened.js";
import { Mini } from "./mini.js";
import { counted, isHouseMeter, powerOf } from "../../summaries.js";
import { openSheet } from "../../tile.js";
import { titled, valueText } from "../../words.js";

const DAYS = 29; // so that each weekday has four before it
const SHOWN = 7;
const LEAST = 1; // watts of what uses something
const DAY = 86_400;

const kilowatts = (value) => value.toLocaleString(locale.value, { minimumFractionDigits: 1, maximumFractionDigits: 1 });
const dateOf = (at) => new Intl.DateTimeFormat("sv-SE", { timeZone: zone.value }).format(at * 1000);
const weekday = (date) => new Intl.DateTimeFormat(locale.value, { weekday: "short", timeZone: "UTC" }).format(new Date(`${date}T12:00:00Z`));

export function Energy() {
  const [days, setDays] = useState(null);
  const metered = shown.value.filter((one) => read(one, "power") !== undefined || read(one, "energy") !== undefined);
  useOpen(() => {
    const since = { sec: Math.floor(now() - DAYS * DAY), nanosec: 0 };
    call("/history/energy", { since }).then((answer) => setDays(answer.days), () => setDays([]));
  }, [metered.length]);
  const users = metered.filter((one) => read(one, "power") >= LEAST && !isHouseMeter(one)).sort((a, b) => read(b, "power") - read(a, "power"));
  const most = Math.max(1, ...users.map((one) => read(one, "power")));
  if (!metered.length) return html`<h1>${say("Energy")}</h1><p class="empty">${say("No device tells its power or energy yet.")}</p>`;
  const largest = users[0];
  return html`<h1>${say("Energy")}</h1>
    <div class="energygrid">
      <section class="card" aria-labelledby="now"><h2 id="now">${say("Now|energy")}</h2><p class="number"><b>${Math.round(powerOf(metered)).toLocaleString(locale.value)}</b> W</p>${largest && html`<p class="quiet">${say("most by {name}", { name: largest.name })}</p><${Mini} device=${largest} capability="power" />`}</section>
      ${days?.length > 0 && html`<${Today} days=${days} /><${Week} days=${days} />`}
      <section class="card users" aria-labelledby="users"><h2 id="users">${say("Who uses it now")}</h2>
        ${users.length ? html`<ul>${users.map((one) => html`<li key=${one.id}><button type="button" onClick=${() => openSheet(one.id)}><span class="icon"><${Sign} path=${signOf(one)} size=${22} /></span><span class="name"><bdi>${one.name}</bdi> <small>${titled(one.room)}</small></span><b>${valueText("power", Math.round(read(one, "power")))}</b><i style=${{ inlineSize: `${(100 * read(one, "power")) / most}%` }}></i></button></li>`)}</ul>` : html`<p class="empty">${say("Nothing that is metered runs.")}</p>`}</section>
    </div>`;
}

const isOfHouse = (day) => isHouseMeter(deviceOf(day.device)?.value);
const sum = (days) => counted(days, isOfHouse).reduce((total, one) => total + one.used, 0);

function Today({ days }) {
  const today = dateOf(now());
  const own = days.filter((one) => one.day === today);
  const same = [1, 2, 3, 4].map((weeks) => dateOf(now() - weeks * 7 * DAY)).map((date) => days.filter((one) => one.day === date)).filter((found) => found.length);
  const usual = same.length ? same.reduce((total, found) => total + sum(found), 0) / same.length : undefined;
  const rooms = new Map();
  const parts = own.filter((one) => !isOfHouse(one));
  for (const one of parts) {
    const room = shown.value.find(({ id }) => id === one.device)?.room ?? "";
    rooms.set(room, (rooms.get(room) ?? 0) + one.used);
  }
  const rest = parts.length < own.length ? sum(own) - sum(parts) : 0;
  const order = [...[...rooms].map(([room, used]) => [room ? titled(room) : say("Without a room"), used]), ...(rest > 0 ? [[say("No meter of its own"), rest]] : [])].sort(([, a], [, b]) => b - a);
  return html`<section class="card" aria-labelledby="today"><h2 id="today">${say("Today")}</h2>
    <p class="number"><b>${kilowatts(sum(own))}</b> kWh</p>
    ${usual !== undefined && html`<p class="compare">${say("{energy} kWh on other days like this", { energy: kilowatts(usual) })}</p>`}
    <ul class="shares">${order.map(([room, used]) => html`<li key=${room}><span>${room}</span><i><i style=${{ inlineSize: `${(100 * used) / (order[0][1] || 1)}%` }}></i></i><b>${kilowatts(used)}</b></li>`)}</ul></section>`;
}

function Week({ days }) {
  const dates = [...Array(SHOWN).keys()].map((before) => dateOf(now() - (SHOWN - 1 - before) * DAY));
  const found = dates.map((date) => [date, sum(days.filter((one) => one.day === date))]);
  const most = Math.max(0.1, ...found.map(([, used]) => used));
  return html`<section class="card" aria-labelledby="week"><h2 id="week">${say("Seven days")} <small>${kilowatts(found.reduce((total, [, used]) => total + used, 0))} kWh</small></h2>
    <ol class="bars">${found.map(([date, used], at) => html`<li key=${date} class=${at === SHOWN - 1 ? "now" : ""}><span>${kilowatts(used)}</span><i style=${{ blockSize: `${(75 * used) / most}%` }}></i><b>${at === SHOWN - 1 ? say("Today") : weekday(date)}</b></li>`)}</ol></section>`;
}
