// What belongs to this screen alone: light or dark, and whether it is at a wall.
import { effect, signal } from "@preact/signals";

const THEME = "homebot.theme";

export const theme = signal(localStorage.getItem(THEME) ?? "");
effect(() => {
  localStorage.setItem(THEME, theme.value);
  document.documentElement.dataset.theme = theme.value;
});

const WALL = "homebot.wall";
const asked = new URLSearchParams(location.search).get("wall"); // a kiosk's address

/** The room of a screen at a wall, "home" for Home; empty for a screen at none. */
export const wall = signal(asked === null ? (localStorage.getItem(WALL) ?? "") : asked === "off" ? "" : asked || "home");
effect(() => localStorage.setItem(WALL, wall.value));

/** The address of the first view of a screen. */
export const startOf = (room) => (room && room !== "home" ? `#/room/${encodeURIComponent(room)}` : "#/home");
