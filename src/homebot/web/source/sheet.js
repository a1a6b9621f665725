// The sheet of a device: its main control, why it is so, today, and the ways to everything else.
import { useEffect, useRef, useState } from "preact/hooks";
import { Added } from "./added.js";
import { Controls } from "./controls.js";
import { may } from "./door.js";
import { deviceOf } from "./house.js";
import { html } from "./html.js";
import { SIGNS, Sign } from "./icons.js";
import { kindOf, signOf, stateOf, toneOf } from "./kinds.js";
import { say } from "./language.js";
import { isKept, keep } from "./layout.js";
import { Lacking, Managing } from "./managing.js";
import { LastKnown, Marks } from "./marks.js";
import { useFull } from "./options.js";
import { Owner } from "./owner.js";
import { Picture, hasPicture } from "./picture.js";
import { closeSheet, giveFocusBack, sheet } from "./tile.js";
import { ActButton } from "./buttons.js";
import { titled } from "./words.js";
import { Why } from "./why.js";

/** What may have a picture: the cover of what it plays, or its map. */
const EXTRA = new Set(["video_player", "speaker", "robotic_vacuum_cleaner", "x_lawn_mower", "generic_switch"]);

const DEAF = 350; // ms in which the touch that opened it may still end

export function Sheet() {
  return sheet.value && deviceOf(sheet.value) ? html`<${Opened} key=${sheet.value} id=${sheet.value} />` : null;
}

function Opened({ id }) {
  const device = deviceOf(id).value;
  const box = useRef(null);
  const [isReady, setIsReady] = useState(false);
  useEffect(() => {
    box.current.focus();
    const timer = setTimeout(() => setIsReady(true), DEAF);
    const onKey = (event) => event.key === "Escape" && closeSheet();
    addEventListener("keydown", onKey);
    document.documentElement.classList.add("covered");
    return () => {
      clearTimeout(timer);
      removeEventListener("keydown", onKey);
      document.documentElement.classList.remove("covered");
      setTimeout(giveFocusBack); // when the page below takes it again
    };
  }, []);
  const kind = kindOf(device);
  const isFavorite = isKept("favorites", id);
  return html`<div class="shade" onClick=${() => isReady && closeSheet()}></div>
    <section ref=${box} class=${isReady ? "sheet" : "sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${toneOf(device)}`}><${Sign} path=${signOf(device)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${device.name}</bdi></h2><p>${[device.room && titled(device.room), stateOf(device)].filter(Boolean).join(" · ")} <${Marks} device=${device} /></p></div>
        ${may("act") && html`<button type="button" class="round" aria-pressed=${String(isFavorite)} aria-label=${say("favorite")} onClick=${() => keep("favorites", id, !isFavorite)}><${Sign} path=${isFavorite ? SIGNS.star : SIGNS.starOff} /></button>`}
        <button type="button" class="round" aria-label=${say("close|do")} onClick=${closeSheet}><${Sign} path=${SIGNS.close} /></button></header>
      <div class="body">
        <${LastKnown} device=${device} />
        ${(hasPicture(device) || EXTRA.has(device.type)) && html`<${Picture} of=${id} text=${device.name} isExtra=${!hasPicture(device)} />`}
        ${device.may_act && (kind.Main ? html`<${kind.Main} device=${device} />` : kind.act?.(device) && html`<div class="solo"><${ActButton} device=${device} act=${kind.act(device)} /></div>`)}
        ${device.settable.length > 0 && html`<${Lacking} right="act" lacks=${!device.may_act} />`}
        ${kind.group === "climate" && html`<${Added} at="next" device=${device} />`}
        <${Why} device=${device} isShort />
        <${Rest} device=${device} main=${[...kind.main, kind.act?.(device)?.capability]} isOnly=${kind.main.length === 0} />
        <details class="part"><summary>${say("Name, room and tags")}</summary><${Managing}><${Owner} device=${device} /><//></details>
        <p class="links"><a href=${`#/device/${encodeURIComponent(id)}`}>${say("Values, history, facts")} <${Sign} path=${SIGNS.right} /></a></p>
        <${Added} at="day" device=${device} />
      </div>
    </section>`;
}

/** The controls that the main control has not. */
function Rest({ device, main, isOnly }) {
  const left = device.settable.filter((one) => !main.includes(one));
  const full = useFull(device.id, left.length > 0);
  if (!left.length || !device.may_act) return null;
  return html`<details class="part" open=${isOnly}><summary>${say("More controls")}</summary>${full && html`<${Controls} short=${device} device=${full} without=${main} />`}</details>`;
}
