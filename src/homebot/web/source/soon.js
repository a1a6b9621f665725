// Views of tiles beside Home, in one file: a link may lead to them at once.
export { Lights } from "./views/lights.js";
export { Room } from "./views/room.js";
