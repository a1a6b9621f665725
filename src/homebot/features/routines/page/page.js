import { later } from "../../later.js";

export const page = { views: { routines: { title: "Routines", View: later(async () => (await import("./routines.js")).Routines), after: "plan" } }, parts: { next: later(async () => (await import("./next.js")).Next) } };
