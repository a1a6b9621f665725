// Televisions and loudspeakers: what they play, and how loud.
import { act, perform, setting } from "../acts.js";
import { Amount } from "../buttons.js";
import { read, takes } from "../house.js";
import { html } from "../html.js";
import { SIGNS, Sign } from "../icons.js";
import { say } from "../language.js";
import { textOf } from "../words.js";

const LOUDER = 5; // per cent

const isOn = (device) => read(device, "on_off") ?? ["playing", "buffering"].includes(read(device, "playback"));
const stateOf = (device) => (read(device, "on_off") === false ? "off" : (read(device, "playback") ?? (isOn(device) ? "on" : "off")));
const plays = (device) => read(device, "playback") === "playing";

function mainAct(device) {
  if (isOn(device) && takes(device, "playback")) return plays(device) ? setting("pause", "playback", "paused") : setting("play", "playback", "playing");
  if (takes(device, "on_off")) return act(isOn(device) ? "turn off" : "turn on", isOn(device) ? "off" : "on", "on_off");
  return takes(device, "playback") ? setting("play", "playback", "playing") : null;
}

function Main({ device }) {
  const volume = read(device, "volume") ?? 0;
  const own = mainAct(device);
  const louder = (step) => () => perform(device, setting("", "volume", Math.min(100, Math.max(0, Math.round(volume + step)))));
  return html`<div class="media">
      ${takes(device, "volume") && html`<button type="button" aria-label=${say("quieter")} onClick=${louder(-LOUDER)}><${Sign} path=${SIGNS.quieter} size=${28} /></button>`}
      ${own && html`<button type="button" class="chief" aria-label=${say(`${own.text}|do`)} onClick=${() => perform(device, own)}><${Sign} path=${{ pause: SIGNS.pause, play: SIGNS.play }[own.text] ?? SIGNS.power} size=${32} /></button>`}
      ${takes(device, "volume") && html`<button type="button" aria-label=${say("louder")} onClick=${louder(LOUDER)}><${Sign} path=${SIGNS.louder} size=${28} /></button>`}
    </div>
    ${takes(device, "volume") && html`<${Amount} device=${device} capability="volume" />`}`;
}

export const media = {
  types: ["video_player", "speaker"],
  group: "media",
  isActive: isOn,
  tone: (device) => (isOn(device) ? "on" : "rest"),
  state: (device) => [textOf("playback", stateOf(device)), ...(isOn(device) ? [read(device, "media_title"), read(device, "media_artist")] : [])].filter(Boolean).join(" · "),
  act: mainAct,
  Main,
  main: ["playback", "volume"],
};
