// The scenes: applied and undone with a button; with the right to it they are saved, edited and removed.
import { signal } from "@preact/signals";
import { useState } from "preact/hooks";
import { agree, tell } from "../../acts.js";
import { ask, call, may, missing } from "../../door.js";
import { html } from "../../html.js";
import { SIGNS, Sign, sceneSign } from "../../icons.js";
import { say, sayReason } from "../../language.js";
import { later } from "../../later.js";
import { Lacking } from "../../managing.js";
import { useOpen } from "../../opened.js";
import { capital, spoken } from "../../words.js";

const NewScene = later(async () => (await import("./edit.js")).NewScene);
const OneScene = later(async () => (await import("./edit.js")).OneScene);
const LONGEST = 300; // seconds until the last part has obeyed

const scenes = signal([]);

export const load = () => call("/scenes/list").then((answer) => (scenes.value = answer.scenes), () => {});

async function apply(scene, more) {
  tell(`${scene.name}: …`, true);
  const { success, message, results = [], asks = [] } = await ask("/scenes/apply", { name: scene.id, ...more }, LONGEST);
  if (asks.length) {
    agree(`${say("undo {name}", { name: scene.name })}: ${asks.map((one) => `${spoken(one.key)} (${one.value})`).join(", ")}`, () => apply(scene, { undo: true, agreed: true }));
    return;
  }
  missing.value = results.find((one) => one.result.policy === "rights")?.result.reason ?? "";
  tell(`${scene.name}: ${sayReason(message ?? "") || say(more.undo ? "undone" : "done")}`, success);
  load();
}

/** The scenes of a room; without one, those of the owner. */
export function Scenes({ room }) {
  const [opened, setOpened] = useState(null); // the scene whose box is open, "new", or null
  useOpen(() => void load());
  const isIn = (scene) => [scene.area, ...scene.parts.map((one) => one.area)].some((one) => one.toLowerCase() === room.toLowerCase());
  const shown = scenes.value.filter((one) => (room === undefined ? !one.is_native : isIn(one)));
  const open = (what) => () => setOpened(what === opened ? null : what);
  const close = () => setOpened(null);
  const start = (scene) => {
    const asking = scene.parts.filter((one) => one.asks).map((one) => `${spoken(one.name)} ${one.text} (${one.asks})`);
    if (asking.length) agree(`${scene.name}: ${asking.join(", ")}`, () => apply(scene, { agreed: true }));
    else apply(scene, {});
  };
  const scene = shown.find((one) => one.id === opened);
  return html`
    <div class="scenes" role="group" aria-label=${say("scenes")}>
      ${shown.map((one) => html`<span key=${one.id} class="scene">
        <button type="button" disabled=${!may("act")} onClick=${() => start(one)}><${Sign} path=${sceneSign(one.name)} size=${22} /> <bdi>${one.name}</bdi></button>
        ${one.can_undo && may("act") && html`<button type="button" aria-label=${say("undo {name}", { name: one.name })} onClick=${() => apply(one, { undo: true, unless_asks: true })}><${Sign} path=${SIGNS.undo} size=${20} /></button>`}
        <button type="button" aria-expanded=${one.id === opened} aria-label=${say("more of {name}", { name: one.name })} onClick=${open(one.id)}><${Sign} path=${SIGNS.more} size=${20} /></button>
      </span>`)}
      ${may("manage") && html`<button type="button" class="new" aria-expanded=${opened === "new"} onClick=${open("new")}><${Sign} path=${SIGNS.plus} size=${20} /> ${capital(say("new scene"))}</button>`}
    </div>
    ${shown.length > 0 && html`<${Lacking} right="act" />`}
    ${opened === "new" && html`<${NewScene} room=${room} onClose=${close} />`}
    ${scene && html`<${OneScene} key=${scene.id} scene=${scene} onClose=${close} />`}`;
}
