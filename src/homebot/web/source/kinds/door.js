// Locks, and the contacts of doors and windows.
import { act } from "../acts.js";
import { ActButton } from "../buttons.js";
import { read, takes } from "../house.js";
import { html } from "../html.js";
import { say } from "../language.js";

const isLocked = (device) => read(device, "lock") === "locked";
const unlocking = () => act("unlock", "unlock", "lock", true);
const locking = () => act("lock", "lock", "lock");

export const lock = {
  types: ["door_lock"],
  group: "doors",
  isActive: (device) => !isLocked(device),
  tone: (device) => (read(device, "lock") === undefined ? "rest" : isLocked(device) ? "secure" : "open"),
  state: (device) => say(read(device, "lock") ?? "unknown"),
  act: (device) => takes(device, "lock") && (isLocked(device) ? unlocking() : locking()),
  Main: ({ device }) => takes(device, "lock") && html`<div class="solo"><${ActButton} device=${device} act=${locking()} /><${ActButton} device=${device} act=${unlocking()} /></div>`,
  main: ["lock"],
};

export const contact = {
  types: ["contact_sensor"],
  group: "doors",
  isActive: (device) => read(device, "contact") === true,
  tone: (device) => (read(device, "contact") ? "open" : "rest"),
  state: (device) => (read(device, "contact") === undefined ? say("unknown") : say(read(device, "contact") ? "open" : "closed")),
  main: [],
};
