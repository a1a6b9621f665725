import { later } from "../../later.js";

export const page = { parts: { routines: later(async () => (await import("./habits.js")).Habits) } };
