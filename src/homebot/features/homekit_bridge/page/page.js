import { later } from "../../later.js";

export const page = { parts: { system: later(async () => (await import("./homekit.js")).Homekit) } };
