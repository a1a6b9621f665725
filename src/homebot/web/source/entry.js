// An entry of the journal, and its text.
import { nameOf } from "./house.js";
import { html } from "./html.js";
import { say, sayReason } from "./language.js";
import { label, outcomeText, settingsText, spoken, timeText, vocabulary } from "./words.js";

/** One entry, with the `outcome` of its command; without the device if that is `own`. */
export function Entry({ entry, outcome, own = "", names }) {
  const { device } = entry;
  return html`<li class=${own ? "own" : ""}>
    <time>${timeText(entry.at)}</time>
    ${!own && html`<span>${device && html`<a href=${`#/device/${encodeURIComponent(device)}`}>${nameOf(device)}</a>`}</span>`}
    <span class=${isBad(entry) ? "bad" : ""}>
      ${own && device && device !== own && `${spoken(names.get(device) ?? nameOf(device))}: `}${entryText(entry)}${outcome && html`: <span class=${isBad(outcome) ? "bad" : "quiet"}>${entryText(outcome)}</span>`}
    </span>
  </li>`;
}

const isBad = (entry) => vocabulary.value.failures.includes(entry.results[0]?.outcome) || entry.kind === "denied" || (entry.kind === "judged" && !entry.verdicts[0]?.allowed);

/** The issuer of a command. */
function issuerText(issuer) {
  if (issuer.startsWith("client:")) return say("the client {name}", { name: issuer.slice(7) });
  return spoken(issuer.replace(/^\//, "")) || say("an unknown program");
}

/** What happened, by an entry of the journal. */
export function entryText(entry) {
  const values = settingsText(entry.settings);
  const issuer = issuerText(entry.issuer);
  const result = entry.results[0];
  switch (entry.kind) {
    case "requested":
      return say("{issuer} asked for {values}", { issuer, values: values || entry.text }) + triggerText(entry.trigger);
    case "judged":
      return verdictText(entry.verdicts[0]);
    case "sent":
      return sentText(entry.text);
    case "acknowledged":
      return say("the network accepted it");
    case "reported":
      return say("reported {values}", { values }) + causeText(entry.cause);
    case "changed":
      return say("changed to {values}", { values }) + causeText(entry.cause);
    case "outcome":
    case "reverted":
      return result ? outcomeText(result) : label(entry.kind);
    case "published":
      return say("{issuer} published {text}", { issuer, text: JSON.stringify(entry.text) });
    case "denied":
      return say("{issuer} was refused: {reason}", { issuer, reason: verdictText(entry.verdicts[0]) });
    default:
      return [label(entry.kind), values, entry.issuer && say("by {issuer}", { issuer })].filter(Boolean).join(" ");
  }
}

function verdictText(verdict) {
  if (!verdict) return "";
  return `${label(verdict.policy)}: ${verdict.reason ? sayReason(verdict.reason) : say(verdict.allowed ? "allowed" : "refused")}`;
}

/** How a command was sent: first, again, or with others in one message to a group or scene, which the text names. */
function sentText(text) {
  if (text === "again" || !text) return say(text ? "sent again" : "sent");
  const [kind, ...name] = text.split(" ");
  return say(kind === "scene" ? "sent in one message to the scene {name}" : "sent in one message to the group {name}", { name: name.join(" ") });
}

function triggerText(trigger) {
  const { scene, is_undo: isUndo } = trigger;
  return (scene ? say(isUndo ? ", as the scene {scene} was undone" : ", as the scene {scene} was applied", { scene }) : "") + causeOf(trigger);
}

function causeOf(trigger) {
  if (!trigger.kind) return "";
  if (trigger.kind === "report" && trigger.readings.length)
    return say(", because {device} reported {values}", { device: spoken(trigger.device.split("/").pop()), values: settingsText(trigger.readings) });
  const [first, ...rest] = trigger.text.split(" ");
  const text = trigger.kind === "client" ? [issuerText(first), ...rest].join(" ") : trigger.text;
  return text ? say(", because of {what}", { what: [spoken(trigger.device.split("/").pop()), text].filter(Boolean).join(" ") }) : "";
}

const CAUSES = {
  command: "",
  transition: ", on its way",
  echo: ", an echo",
  device: ", by itself",
  program: ", by another program",
  person: ", by a person",
  unknown: ", by the device or a person",
};

const causeText = (cause) => (CAUSES[cause] ? say(CAUSES[cause]) : "");
