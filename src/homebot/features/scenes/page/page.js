import { Scenes } from "./scenes.js";

export const page = { parts: { scenes: Scenes } };
