// Apps, gateways and what is wrong; devices that wait for approval.
import { useEffect, useState } from "preact/hooks";
import { tell } from "../acts.js";
import { Added } from "../added.js";
import { ask, call, connection, may, subscribeFrames } from "../door.js";
import { deviceOf, nameOf } from "../house.js";
import { html } from "../html.js";
import { locale, say, sayReason } from "../language.js";
import { Managing } from "../managing.js";
import { useOpen } from "../opened.js";
import { Screen } from "./screen.js";
import { capital, label, seconds, spoken, timeIn, timeText } from "../words.js";

/** What the owner changes, and two views more. */
const SETUP = { "setup/home": "Name and place", "setup/devices": "Devices", "setup/rooms": "Rooms", "setup/people": "People", "setup/alerts": "Alerts", "setup/screens": "Screens", "setup/backup": "Backup", graph: "Graph", rates: "Rates" };
const AGAIN = 5000; // ms
const LINES = 50; // of the log
const WARNING = 30;

export function System() {
  const [found, setFound] = useState(null);
  const [approved, setApproved] = useState(0);
  useOpen(async (isCurrent) => {
    const now = await examine();
    if (isCurrent()) setFound(now);
    return AGAIN;
  }, [approved]);
  if (!found) return html`<p class="empty">${say("Asking homebot how it is …")}</p>`;
  return html`
    <nav class="choices" aria-label=${say("Set up")}>${Object.entries(SETUP).map(([name, text]) => html`<a key=${name} href=${`#/${name}`}>${say(text)}</a>`)}</nav>
    <${Waiting} devices=${found.waiting} onApproved=${() => setApproved(approved + 1)} />
    <section>
      <h2>${say("Doctor")}</h2>
      ${found.findings.every((one) => !one.is_problem) && html`<p>${say(found.findings.length ? "Nothing is wrong. To note:" : "Nothing is wrong.")}</p>`}
      <ul class="entries">${found.findings.map((one) => html`<${Finding} key=${one.code + one.where} finding=${one} />`)}</ul>
    </section>
    <div class="columns">
      ${found.apps && html`<section>
        <h2>${say("Apps")}</h2>
        ${!found.apps.length && html`<p class="empty">${say("No app runs.")}</p>`}
        <table class="facts"><tbody>
          ${found.apps.map((app) => html`<tr key=${app.name}><th scope="row">${spoken(app.name)}</th><td class=${app.state === "running" ? "" : "bad"}>${say(app.state)}${app.jobs.map((job) => html`<br /><small>${jobText(job, found.zone)}</small>`)}</td></tr>`)}
        </tbody></table>
      </section>`}
      ${found.gateways.map((part) => html`<section key=${part.name}>
        <h2>${capital(sayReason(part.text))}</h2>
        ${part.counts.every((one) => !one.count) && html`<p class="empty">${say("Nothing is counted yet.")}</p>`}
        <table class="facts"><tbody>
          ${part.counts.filter((one) => one.count).map((one) => html`<tr key=${one.name}><th scope="row">${label(one.name)}</th><td>${one.count.toLocaleString(locale.value)}</td></tr>`)}
        </tbody></table>
        ${may("manage") && html`<p class="buttons"><button type="button" onClick=${() => restart(part.name)}>${say("start {name} again", { name: part.name })}</button></p>`}
      </section>`)}
      <${Screen} />
      <${Added} at="system" />
    </div>
    <${Log} />
    <${Connection} />`;
}

const restart = async (gateway) => {
  const { success, message } = await ask("/homebot/restart_gateway", { gateway });
  tell(sayReason(message), success);
};

/** What the connection lacks, or what another device needs to trust it. */
function Connection() {
  const [hasAuthority, setHasAuthority] = useState(false);
  useEffect(() => {
    fetch("authority.crt", { method: "HEAD" }).then((answer) => setHasAuthority(answer.status === 200), () => {});
  }, []);
  if (!isSecureContext) return html`<p class="legend">${say("Without TLS a browser installs no app: set tls = true in [door].")}</p>`;
  return hasAuthority && html`<p class="legend"><a href="authority.crt" download>${say("The certificate that your devices are to trust")}</a></p>`;
}

/** The newest lines of the log, of apps too. */
function Log() {
  const [lines, setLines] = useState([]);
  useEffect(() => subscribeFrames("/rosout", (found) => setLines((old) => [...found].reverse().concat(old).slice(0, LINES))), []);
  return html`<section>
    <h2>${say("Log")}</h2>
    ${!lines.length && html`<p class="empty">${say("Lines appear here as they come.")}</p>`}
    <ol class="log">
      ${lines.map((one, index) => html`<li key=${lines.length - index}><time>${timeText(one.stamp)}</time><span>${one.name}</span><span class=${one.level >= WARNING ? "bad" : ""}>${one.msg}</span></li>`)}
    </ol>
  </section>`;
}

/** A finding of the doctor, with the devices that it is about. */
function Finding({ finding }) {
  const more = finding.total - finding.rows.length;
  const nameIn = (row) => (deviceOf(row.what) ? html`<a href=${`#/device/${encodeURIComponent(row.what)}`}>${nameOf(row.what)}</a>` : say(row.what));
  return html`<li>
    <span class=${finding.is_problem ? "bad" : ""}>${finding.code} ${finding.title && `${sayReason(finding.title)}:`}</span>
    ${finding.rows.map((row, index) => html` ${(row.what || index > 0) && html`<br />`}${nameIn(row)} ${row.why !== nameOf(row.what) && sayReason(row.why)}`)}
    ${more > 0 && html`<br />${say("… and {count} more", { count: more })}${finding.hint}`}
    ${finding.next && html`<br /><small>→ ${say(finding.next)}</small>`}
  </li>`;
}

const jobName = ({ name, text }) => (name.includes(text) ? name : `${name} (${text})`);

const jobText = (job, zone) => [jobName(job), job.note || (seconds(job.next) > 0 && `${say("next")} ${timeIn(zone, job.next)}`)].filter(Boolean).join(", ");

async function examine() {
  const nothing = { gateways: [], findings: [] };
  const noAnswer = (error) => ({ ...nothing, findings: [{ code: "", where: "", title: error.message, is_problem: true, rows: [], total: 0, next: "" }] });
  const found = await call("/rosapi/doctor").catch(noAnswer);
  const counts = (name) => call(`/gateway/${name}/health`).catch(() => ({ counts: [] }));
  const gateways = await Promise.all(found.gateways.map(async (one) => ({ ...one, ...(await counts(one.name)) })));
  const waiting = await call("/control/unapproved").catch(() => ({ devices: [], reasons: [] }));
  const { apps, zone } = await call("/apps/list").catch(() => ({}));
  return { gateways, findings: found.findings.sort((a, b) => b.is_problem - a.is_problem), waiting, apps, zone };
}

function Waiting({ devices, onApproved }) {
  const [shown, setShown] = useState(null);
  if (!devices.devices.length) return null;
  const reasons = new Map(devices.reasons.map((one) => [one.key, one.value]));
  const show = async (device) => {
    const answer = await ask("/discovery/approve", { device, is_preview: true });
    setShown({ device, ...answer });
  };
  const approve = async () => {
    const answer = await ask("/discovery/approve", { device: shown.device, digest: shown.digest });
    setShown(answer.success ? null : { device: shown.device, ...answer });
    if (answer.success) onApproved();
  };
  return html`<section>
    <h2>${say("Waiting for your approval")}</h2>
    <${Managing} />
    <ul class="entries">
      ${devices.devices.map((id) => html`<li key=${id}>
        <div class="choices">
          <a href=${`#/device/${encodeURIComponent(id)}`}>${nameOf(id)}</a> <span>${sayReason(reasons.get(id) ?? "")}</span>
          ${may("manage") && html`<button type="button" aria-label=${say("show what approving {name} allows", { name: nameOf(id) })} onClick=${() => show(id)}>${say("show")}</button>`}
        </div>
        ${shown?.device === id && html`<div class="box">
          ${shown.message && html`<p class="bad">${sayReason(shown.message)}</p>`}
          ${shown.commands?.length > 0 && html`<p>${say("Approval allows these commands:")}</p><pre>${shown.commands.join("\n")}</pre>`}
          ${shown.changes?.length > 0 && html`<p>${say("Changed since the approval before:")}</p><pre>${shown.changes.join("\n")}</pre>`}
          ${shown.success && html`<p class="choices"><button type="button" onClick=${approve}>${say("approve {name}", { name: nameOf(id) })}</button></p>`}
        </div>`}
      </li>`)}
    </ul>
  </section>`;
}
