// What a second touch shows, in one file, which is loaded after the first view.
export { Sheet } from "./sheet.js";
export { Lately } from "./views/lately.js";
export { More } from "./views/more.js";
export { LogIn } from "./views/screen.js";
