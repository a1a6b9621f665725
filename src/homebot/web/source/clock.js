// The house's clock and time zone, by which the page shows every moment.
import { signal } from "@preact/signals";

let start = performance.timeOrigin / 1000; // seconds since the Unix epoch, when performance.now() was 0

/** The zone; undefined, which is the browser's, until it is told, or where the browser does not know it. */
export const zone = signal(undefined);

/** Seconds since the Unix epoch: the clock of a tablet may be wrong, or be set meanwhile. */
export const now = () => start + performance.now() / 1000;

export function setTime({ sec, nanosec }) {
  start = sec + nanosec / 1e9 - performance.now() / 1000;
}

export function setZone(name) {
  try {
    new Intl.DateTimeFormat([], { timeZone: name });
    zone.value = name;
  } catch {
    zone.value = undefined;
  }
}
