import { Alerts, urgent } from "./alerts.js";

export const page = { parts: { top: Alerts }, urgent };
