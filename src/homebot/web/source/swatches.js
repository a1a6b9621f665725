// The white of a lamp, its color, and its effects, as large buttons.
import { perform, setting } from "./acts.js";
import { read, takes } from "./house.js";
import { html } from "./html.js";
import { say } from "./language.js";
import { useOptions } from "./options.js";
import { capital } from "./words.js";

const WHITES = [["candle", 2200, "#ffb46b"], ["warm", 2700, "#ffd0a1"], ["neutral", 4000, "#fff0dd"], ["daylight", 6000, "#e8f1ff"]];
const NEAR = 150; // kelvin
/** Hue and saturation. */
const COLORS = [["red", 0, 95], ["orange", 28, 95], ["yellow", 52, 90], ["green", 120, 85], ["blue", 225, 90], ["violet", 275, 80], ["pink", 320, 60]];

export function Swatches({ device }) {
  const effects = useOptions(device, "effect");
  const kelvin = read(device, "color_temperature");
  const [hue, saturation] = read(device, "color") ?? [];
  return html`
    ${takes(device, "color_temperature") && html`<fieldset class="swatches"><legend>${say("white")}</legend>${WHITES.map(([text, own, background]) => html`<button key=${own} type="button" aria-pressed=${String(Math.abs(kelvin - own) < NEAR)} onClick=${() => perform(device, setting("", "color_temperature", own))}><span style=${{ background }}></span>${capital(say(text))}</button>`)}</fieldset>`}
    ${takes(device, "color") && html`<fieldset class="swatches bare"><legend>${say("color")}</legend>${COLORS.map(([text, ...own]) => html`<button key=${text} type="button" aria-label=${say(text)} aria-pressed=${String(Math.abs(hue - own[0]) < 8 && Math.abs(saturation - own[1]) < 15)} onClick=${() => perform(device, setting("", "color", own.join(",")))}><span style=${{ background: `hsl(${own[0]} ${own[1]}% 50%)` }}></span></button>`)}</fieldset>`}
    ${effects.length > 0 && html`<fieldset class="swatches"><legend>${say("light effect")}</legend>${effects.map((one) => html`<button key=${one} type="button" aria-pressed=${String(read(device, "effect") === one)} onClick=${() => perform(device, setting("", "effect", one))}>${one}</button>`)}</fieldset>`}`;
}
