import { later } from "../../later.js";
import { Alerts, urgent } from "./alerts.js";

export const page = { parts: { top: Alerts, addresses: later(async () => (await import("./addresses.js")).Addresses) }, urgent };
