// What the owner says of a device: its name, room and tags, and whether the page hides it.
import { useState } from "preact/hooks";
import { ask, call } from "./door.js";
import { html, written } from "./html.js";
import { isHidden, rooms } from "./house.js";
import { say, sayReason } from "./language.js";
import { keep } from "./layout.js";
import { Managing } from "./managing.js";
import { useOpen } from "./opened.js";

const wordsIn = (text) => text.split(",").map((one) => one.trim()).filter(Boolean);

export function Owner({ device }) {
  const [places, setPlaces] = useState([]);
  const [told, setTold] = useState(null);
  const [isDoubtful, setIsDoubtful] = useState(false);
  useOpen(() => void call("/discovery/places").then((answer) => setPlaces(answer.rooms.map((one) => one.name)), () => {}));
  const known = [...new Set([...places, ...rooms.value.map(([name]) => name)])].filter(Boolean);
  const list = `rooms of ${device.id}`;
  const submit = async (event) => {
    const given = written(event);
    const [name, room] = [given.get("name").trim(), given.get("room").trim()];
    const tags = wordsIn(given.get("tags"));
    const hides = given.get("hidden") === "on";
    const calls = [
      ...(name === device.given ? [] : [["alias", name ? { alias: name } : { alias: device.given, remove: true }]]),
      ...(room === device.room ? [] : [["place", { room, is_new: given.get("new") === "on" }]]),
      ...tags.filter((one) => !device.tags.includes(one)).map((tag) => ["tag", { tag }]),
      ...device.tags.filter((one) => !tags.includes(one)).map((tag) => ["tag", { tag, remove: true }]),
    ];
    const problems = [];
    for (const [what, args] of calls) {
      const { success, message } = await ask(`/discovery/${what}`, { device: device.id, ...args });
      if (message) problems.push(sayReason(message));
      if (what === "place") setIsDoubtful(!success);
    }
    if (hides !== isHidden(device.id)) await keep("hidden", device.id, hides);
    setTold(problems);
  };
  return html`<${Managing}><form class="fields" onSubmit=${submit}>
    <label><span>${say("Name")}</span> <input name="name" maxlength="200" defaultValue=${device.given} /></label>
    <label><span>${say("Room")}</span> <input name="room" maxlength="200" list=${list} defaultValue=${device.room} /></label>
    <datalist id=${list}>${known.map((one) => html`<option key=${one} value=${one} />`)}</datalist>
    ${isDoubtful && html`<label><input type="checkbox" name="new" /> ${say("a new room")}</label>`}
    <label><span>${say("Tags")}</span> <input name="tags" defaultValue=${device.tags.join(", ")} /></label>
    <label><input type="checkbox" name="hidden" defaultChecked=${isHidden(device.id)} /> ${say("hide it in the house")}</label>
    <p class="buttons"><button>${say("save")}</button></p>
    <p role="status" class=${told?.length ? "bad" : "quiet"}>${told && (told.join("; ") || say("saved"))}</p>
  </form><//>`;
}
