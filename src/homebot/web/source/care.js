// System, and what it leads to, in one file.
export { Graph } from "./views/graph.js";
export { Rates } from "./views/rates.js";
export { Setup } from "./views/setup.js";
export { System } from "./views/system.js";
