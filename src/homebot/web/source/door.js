// The connection to homebot: rosbridge v2, as every other client speaks it.
import { signal } from "@preact/signals";
import { now, setTime, setZone } from "./clock.js";

const FIRST_DELAY = 500; // ms until the first attempt to connect again, twice as long each time
const LONGEST_DELAY = 10_000;
const ANSWER_WITHIN = 15; // seconds
const ASK_EVERY = 25; // seconds between two questions whether homebot is there
const PATIENCE = 5; // seconds for the answer to one
const TOKEN = "homebot.token";
const CODE = /^[2-9A-Z]{4}-?[2-9A-Z]{4}$/i;
export const EXPIRED = "This code is not valid any more: homebot prints another when it starts.";
const OWN_RIGHTS = ["read", "act: all", "manage"];

/** "connecting", "open", or "refused": a token is needed; with the reason in `reason`, the home's name, and the page's build. */
export const connection = signal({ state: "connecting", reason: "", home: "", build: "" });

/** When homebot was last heard, in seconds since the Unix epoch; 0 for never in this tab. */
export const heardAt = signal(0);

/** The right that the last request lacked, as homebot says it: the page asks for a token. */
export const missing = signal("");

/** The rights of this page, by their first words: read, act, manage, … */
const rights = signal([]);
export const may = (right) => rights.value.includes(right);

/** What a new connection asks, all at once. */
const FIRST = [["/rosapi/rights", "page-rights"], ["/rosapi/get_time", "page-time"], ["/apps/list", "page-zone"], ["/homebot/health", "page-open"]];

const calls = new Map(); // by id: resolve, reject, timer
const topics = new Map(); // by topic: handlers
const openers = new Set(); // called with each new connection
let socket = null;
let delay = FIRST_DELAY;
let number = 0;
let retry = 0;
let watch = 0;
let isHeard = false;

/** The code that `homebot run` prints: it lets this screen in once, which makes a token of its own then. */
let code = "";

/** The token that was typed in; kept for this tab, or where `remember` says so for this browser. */
export const token = signal(takeToken());

export function logIn(text, remember) {
  missing.value = "";
  if (CODE.test(text)) {
    code = text.replace("-", "").toUpperCase();
    reconnect();
    return;
  }
  sessionStorage.setItem(TOKEN, text);
  if (remember) localStorage.setItem(TOKEN, text);
  else localStorage.removeItem(TOKEN);
  token.value = text;
  reconnect();
}

export function logOut() {
  sessionStorage.removeItem(TOKEN);
  localStorage.removeItem(TOKEN);
  token.value = "";
  reconnect();
}

/** Call `handler` now, and with each later connection. */
export function onOpen(handler) {
  openers.add(handler);
  if (connection.value.state === "open") handler();
  return () => openers.delete(handler);
}

/** Return the values of the answer, which may take `timeout` seconds; an Error says why there is none. */
export function call(service, args = {}, timeout = 0) {
  return new Promise((resolve, reject) => {
    if (connection.value.state !== "open") {
      reject(new Error("homebot cannot be reached"));
      return;
    }
    const id = `page-${++number}`;
    const timer = setTimeout(() => finish(id, new Error(`${service} did not answer`)), 1000 * (timeout || ANSWER_WITHIN));
    calls.set(id, { resolve, reject, timer });
    send({ op: "call_service", service, args, id, timeout, patience: timeout || ANSWER_WITHIN });
  });
}

/** Return the answer of a service that tells its success; a failure of the call is an answer too. */
export const ask = (service, args, timeout) => call(service, args, timeout).catch((error) => ({ success: false, message: error.message }));

/** Call `handler` with each message of `topic`; returns the function that ends it. */
export function subscribe(topic, handler) {
  if (!topics.has(topic)) {
    topics.set(topic, new Set());
    if (connection.value.state === "open") send({ op: "subscribe", topic });
  }
  topics.get(topic).add(handler);
  return () => {
    const handlers = topics.get(topic);
    handlers?.delete(handler);
    if (handlers?.size === 0) {
      topics.delete(topic);
      if (connection.value.state === "open") send({ op: "unsubscribe", topic });
    }
  };
}

/** Call `handler` once a frame with what came on `topic` meanwhile, in order; returns the function that ends it. */
export function subscribeFrames(topic, handler) {
  let found = [];
  return subscribe(topic, (message) => {
    if (found.push(message) > 1) return;
    requestAnimationFrame(() => {
      handler(found);
      found = [];
    });
  });
}

/** Make a token; the answer has it, or says why there is none. */
export const makeToken = (name, grants) => ask("/setup/token", { name, grants }, 60);

/** Get a token for this screen, in place of the code that let it in. */
async function becomeKnown() {
  code = "";
  const { token: own, message } = await makeToken(`screen-${crypto.getRandomValues(new Uint32Array(1))[0].toString(36)}`, OWN_RIGHTS);
  if (!own) {
    missing.value = message;
    return;
  }
  logIn(own, true);
  location.hash = "#/setup";
}

export function connect() {
  // The link may be opened where the page is open already, which loads nothing.
  addEventListener("hashchange", () => {
    const given = takeToken();
    if (given === token.value && !code) return;
    token.value = given;
    reconnect();
  });
  // A page that is not looked at costs homebot nothing.
  document.addEventListener("visibilitychange", reconnect);
  reconnect();
}

function reconnect() {
  clearTimeout(retry);
  clearTimeout(watch);
  const old = socket;
  socket = null;
  old?.close();
  failAll();
  delay = FIRST_DELAY;
  if (!document.hidden) open();
}

function open() {
  if (connection.value.state !== "connecting") become("connecting");
  const own = new WebSocket(location.origin.replace(/^http/, "ws"), "homebot.log_in");
  socket = own;
  expectAnswer(own, ANSWER_WITHIN);
  own.onopen = () => {
    own.send(JSON.stringify({ op: "auth", token: code || token.value }));
    for (const topic of topics.keys()) own.send(JSON.stringify({ op: "subscribe", topic }));
    for (const [service, id] of FIRST) own.send(dated({ op: "call_service", service, id }));
  };
  own.onmessage = (event) => receive(own, JSON.parse(event.data));
  own.onclose = (event) => lose(own, event);
}

function lose(own, { code: status, reason } = {}) {
  if (socket !== own) return;
  socket = null;
  clearTimeout(watch);
  if (connection.value.state === "open") heardAt.value = now();
  failAll();
  if (status === 1008) {
    become("refused", code ? EXPIRED : reason);
    code = "";
    return;
  }
  become("connecting", "homebot cannot be reached");
  retry = setTimeout(open, delay);
  delay = Math.min(2 * delay, LONGEST_DELAY);
}

/** Give up a link on which nothing comes in time, and ask again on one that works: a link that breaks may never be closed. */
function expectAnswer(own, within) {
  isHeard = false;
  watch = setTimeout(() => {
    if (!isHeard) {
      lose(own);
      own.close();
      return;
    }
    watch = setTimeout(() => {
      expectAnswer(own, PATIENCE);
      askTime();
    }, 1000 * (ASK_EVERY - within));
  }, 1000 * within);
}

const askTime = () => send({ op: "call_service", service: "/rosapi/get_time", id: "page-time" });

function receive(own, frame) {
  if (socket !== own) return;
  isHeard = true;
  if (frame.op === "publish") {
    for (const handler of topics.get(frame.topic) ?? []) handler(frame.msg);
  } else if (frame.op === "service_response" && frame.id === "page-rights") {
    // Only an answer proves that the token was accepted.
    rights.value = frame.values?.rights ?? [];
  } else if (frame.id === "page-time") {
    if (frame.result) setTime(frame.values.time);
  } else if (frame.id === "page-zone") {
    if (frame.result) setZone(frame.values.zone);
  } else if (frame.op === "service_response" && frame.id === "page-open") {
    delay = FIRST_DELAY;
    become("open", "", frame.values);
    for (const opener of openers) opener();
    if (code) becomeKnown();
  } else if (frame.op === "service_response") {
    const problem = frame.result ? "" : String(frame.values);
    if (problem.startsWith("the right ")) missing.value = problem;
    finish(frame.id, problem && new Error(problem), frame.values);
    if (problem.includes(" came too late, ")) reconnect(); // or the clock of this computer was set back
  }
}

function finish(id, error, values) {
  const waiting = calls.get(id);
  if (!waiting) return;
  calls.delete(id);
  clearTimeout(waiting.timer);
  if (error) waiting.reject(error);
  else waiting.resolve(values);
}

function failAll() {
  for (const id of [...calls.keys()]) finish(id, new Error("homebot cannot be reached"));
}

function become(state, reason = "", { home, build } = connection.value) {
  connection.value = { state, reason, home, build };
}

/** A frame with its time, by which homebot knows what a link that was silent delivers too late. */
const dated = (frame) => JSON.stringify({ ...frame, sent: Date.now() / 1000 });

function send(frame) {
  socket?.send(dated(frame));
}

function takeToken() {
  // `homebot run` may print …/#token=…: a fragment is sent nowhere, and goes from the address at once.
  const words = new URLSearchParams(location.hash.slice(1));
  const given = words.get("token");
  if (CODE.test(words.get("code") ?? "")) {
    code = words.get("code").replace("-", "").toUpperCase();
    history.replaceState(null, "", location.pathname);
  }
  if (given) {
    sessionStorage.setItem(TOKEN, given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem(TOKEN) ?? localStorage.getItem(TOKEN) ?? "";
}
