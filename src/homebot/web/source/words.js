// Values, times and causes as people read them.
import { signal } from "@preact/signals";

/** Unit of each capability of the vocabulary. */
export const units = signal({});

export async function loadUnits() {
  const answer = await fetch("vocabulary.json");
  if (answer.ok) units.value = await answer.json();
}

const TRUE = {
  on_off: ["on", "off"],
  contact: ["open", "closed"],
  occupancy: ["occupied", "clear"],
  smoke: ["smoke", "clear"],
  water_leak: ["wet", "dry"],
};

/** A value of a capability, with its unit. */
export function valueText(capability, value, unit = "") {
  if (value === null || value === undefined) return "unknown";
  if (typeof value === "boolean") {
    const [yes, no] = TRUE[capability] ?? ["yes", "no"];
    return value ? yes : no;
  }
  if (typeof value === "number") {
    const own = unit || units.value[capability] || "";
    const text = Number.isInteger(value) ? String(value) : String(Number(value.toFixed(Math.abs(value) < 10 ? 2 : 1)));
    return own ? `${text} ${own}` : text;
  }
  return Array.isArray(value) ? value.map((one) => Math.round(one)).join(", ") : String(value);
}

export const label = (name) => name.replaceAll("_", " ");

/** The values of a device in one line, the most telling first. */
export function summary(device) {
  const found = [...device.states.values()].filter((one) => one.value !== null);
  const isOff = found.some((one) => one.capability === "on_off" && one.value === false);
  return found
    .filter((one) => !(isOff && (one.capability === "level" || one.capability.startsWith("color"))))
    .slice(0, 4)
    .map(readingText)
    .join(", ");
}

export const seconds = (time) => time.sec + time.nanosec / 1e9;

const clock = new Intl.DateTimeFormat([], { hour: "2-digit", minute: "2-digit", second: "2-digit", hour12: false });
const day = new Intl.DateTimeFormat([], { month: "short", day: "numeric" });

/** A moment: the time of today, else day and time; empty for none. */
export function timeText(time) {
  const at = seconds(time);
  if (!at) return "";
  const date = new Date(at * 1000);
  const text = clock.format(date);
  return date.toDateString() === new Date().toDateString() ? text : `${day.format(date)} ${text}`;
}

/** A length of time, in its two largest units. */
export function durationText(length) {
  if (length < 1) return `${Math.round(length * 1000)} ms`;
  const units = [["d", 86_400], ["h", 3600], ["min", 60], ["s", 1]];
  const first = units.findIndex(([, size]) => length >= size);
  let rest = length;
  return units
    .slice(first, first + 2)
    .map(([name, size]) => {
      const many = Math.floor(rest / size);
      rest -= many * size;
      return many ? `${many} ${name}` : "";
    })
    .filter(Boolean)
    .join(" ");
}

export const settingsText = (settings) => settings.map(readingText).join(", ");

const readingText = (one) =>
  (one.capability === "on_off" ? "" : `${label(one.capability)} `) + valueText(one.capability, one.value);

/** The issuer of a command. */
export function issuerText(issuer) {
  if (issuer.startsWith("client:")) return `the client ${issuer.slice(7)}`;
  return issuer ? `the app ${issuer.replace(/^\//, "")}` : "somebody";
}

/** What happened, by an entry of the journal. */
export function entryText(entry) {
  const values = settingsText(entry.settings);
  const result = entry.results[0];
  switch (entry.kind) {
    case "requested":
      return `${issuerText(entry.issuer)} asked for ${values || entry.text}${triggerText(entry.trigger)}`;
    case "judged":
      return verdictText(entry.verdicts[0]);
    case "sent":
      return entry.text === "again" ? "sent again" : "sent";
    case "acknowledged":
      return "the network accepted it";
    case "reported":
      return `reported ${values}${causeText(entry.cause)}`;
    case "changed":
      return `changed to ${values}${causeText(entry.cause)}`;
    case "outcome":
    case "reverted":
      return result ? result.text : entry.kind;
    case "published":
      return `${issuerText(entry.issuer)} published ${JSON.stringify(entry.text)}`;
    case "denied":
      return `${issuerText(entry.issuer)} was refused: ${verdictText(entry.verdicts[0])}`;
    default:
      return [label(entry.kind), values, entry.issuer && `by ${issuerText(entry.issuer)}`].filter(Boolean).join(" ");
  }
}

function verdictText(verdict) {
  if (!verdict) return "";
  if (verdict.reason) return `${label(verdict.policy)}: ${verdict.reason}`;
  return verdict.allowed ? `${label(verdict.policy)}: allowed` : `${label(verdict.policy)}: refused`;
}

function triggerText(trigger) {
  if (!trigger.kind) return "";
  if (trigger.kind === "report" && trigger.readings.length)
    return `, because ${trigger.device} reported ${settingsText(trigger.readings)}`;
  return trigger.text ? `, because of ${trigger.text}` : "";
}

const CAUSES = {
  command: "",
  transition: ", on its way",
  echo: ", an echo",
  device: ", by itself",
  person: ", by a person",
  unknown: ", by the device or a person",
};

const causeText = (cause) => CAUSES[cause] ?? "";
