// Scenes as buttons: those of the owner in the house, the others too in their room.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { tell } from "./acting.js";
import { call, connection, missing } from "./door.js";
import { html } from "./html.js";
import { say } from "./language.js";

const scenes = signal([]);

const load = () => call("/scenes/list").then((answer) => (scenes.value = answer.scenes), () => {});

async function apply(scene, undo) {
  tell(`${scene.name}: …`, true);
  try {
    const { success, message, results } = await call("/scenes/apply", { name: scene.id, undo });
    missing.value = results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
    tell(`${scene.name}: ${message || say(undo ? "undone" : "done")}`, success);
  } catch (error) {
    tell(`${scene.name}: ${error.message}`, false);
  }
  load();
}

/** The scenes of a room; without one, those of the owner. */
export function Scenes({ room }) {
  const isOpen = connection.value.state === "open";
  useEffect(() => {
    if (isOpen) load();
  }, [isOpen]);
  const isIn = (scene) => [scene.area, ...scene.parts.map((one) => one.area)].some((one) => one.toLowerCase() === room.toLowerCase());
  const shown = scenes.value.filter((one) => (room === undefined ? !one.is_native : isIn(one)));
  if (!shown.length) return null;
  return html`<div class="choices" role="group" aria-label=${say("scenes")}>
    ${shown.map((one) => html`<button key=${one.id} type="button" class="scene" onClick=${() => apply(one, false)}><bdi>${one.name}</bdi></button>
      ${one.can_undo && html`<button key=${`${one.id} undo`} type="button" aria-label=${say("undo {name}", { name: one.name })} onClick=${() => apply(one, true)}>↶</button>`}`)}
  </div>`;
}
