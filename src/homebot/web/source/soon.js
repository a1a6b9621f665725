// What a second touch shows, in one file, which is loaded after the first view.
export { Sheet } from "./sheet.js";
export { Lights } from "./views/lights.js";
export { More } from "./views/more.js";
export { Room } from "./views/room.js";
export { LogIn } from "./views/screen.js";
