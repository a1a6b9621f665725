// Views that the rail and tiles lead to, in one file, which packs better than five.
export { Climate } from "./views/climate.js";
export { Device } from "./views/device.js";
export { Journal } from "./views/journal.js";
export { Plan } from "./views/plan.js";
export { Security } from "./views/security.js";
