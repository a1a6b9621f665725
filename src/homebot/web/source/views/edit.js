// Editing of Home: the owner's stars, order, icons and hidden things, which every screen shows.
import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { deviceOf, isHidden, rooms } from "../house.js";
import { html } from "../html.js";
import { PLACES, SIGNS, Sign, choicesOf, roomSign, thingSigns } from "../icons.js";
import { signOf } from "../kinds.js";
import { say } from "../language.js";
import { changeLayout, iconOf, isKept, keep, layout, roomKey } from "../layout.js";
import { allRooms } from "../summaries.js";
import { capital, label, titled } from "../words.js";

export function Edit({ ids, onDone }) {
  const [picking, setPicking] = useState(""); // the key of the thing whose icon is chosen
  const { favorites } = layout.value;
  const own = ids.filter((id) => favorites.includes(id));
  const names = allRooms.value.map(([room]) => room).filter(Boolean);
  const away = rooms.value.flatMap(([, found]) => found).filter((id) => isHidden(id) || isKept("not_here", id));
  const box = useRef(null);
  const focus = useRef("");
  useLayoutEffect(() => {
    box.current.querySelector(".chief").focus();
  }, []);
  useLayoutEffect(() => {
    // What moves loses the focus; a place at the end has no way on.
    const { activeElement: held } = document;
    if (focus.current && (held.disabled || !box.current.contains(held))) box.current.querySelector(`[data-step="${CSS.escape(focus.current)}"] .step:enabled`)?.focus();
  });
  const move = (list, all, name, step) => {
    const at = all.indexOf(name) + step;
    const left = all.filter((one) => one !== name);
    focus.current = name;
    changeLayout("order", { list, names: [...left.slice(0, at), name, ...left.slice(at)] });
  };
  const Row = ({ name, text, room, mark, path, choices, icons, list, all, children }) => html`<li key=${name} data-step=${name} class="editrow">
      ${!choices.length && html`<span class="icon"><${Sign} path=${path} /></span>`}${choices.length > 0 && html`<button type="button" class="icon" aria-expanded=${picking === mark} aria-label=${`${text}: ${say("icon")}`} onClick=${() => setPicking(picking === mark ? "" : mark)}><${Sign} path=${path} /></button>`}
      <span class="name"><bdi>${text}</bdi>${room && html` <small>${titled(room)}</small>`}</span>
      <span class="ways">${all.includes(name) && html`<${Step} text=${`${text}: ${say("earlier")}`} path=${SIGNS.left} isOff=${all[0] === name} onClick=${() => move(list, all, name, -1)} /><${Step} text=${`${text}: ${say("later")}`} path=${SIGNS.right} isOff=${all.at(-1) === name} onClick=${() => move(list, all, name, 1)} />`}${children}</span>
      ${picking === mark && html`<span class="picks" role="group" aria-label=${say("icon")}>${choices.map((one) => html`<button key=${one} type="button" aria-pressed=${iconOf(mark) === one} aria-label=${label(one)} onClick=${() => changeLayout("icon", { names: [mark], icon: iconOf(mark) === one ? "" : one })}><${Sign} path=${icons(one)} /></button>`)}</span>`}
    </li>`;
  return html`<div ref=${box} class="editing">
    <div class="head"><p class="legend">${say("What you change here, every screen shows.")}</p>
      <p class="ways"><button type="button" disabled=${!layout.value.undoes} onClick=${() => changeLayout("undo")}><${Sign} path=${SIGNS.undo} size=${20} /> ${capital(say("undo"))}</button><button type="button" class="chief" onClick=${onDone}>${capital(say("done"))}</button></p></div>
    <section aria-labelledby="stars"><h2 id="stars">${say("Favorites")}</h2><ul class="edits">
      ${ids.map((id) => {
        const { name: text, room } = deviceOf(id).value;
        const isOwn = own.includes(id);
        return Row({ name: id, text, room, mark: id, path: signOf(deviceOf(id).value), choices: choicesOf(deviceOf(id).value), icons: (one) => thingSigns(one)[0], list: "favorites", all: own, children: html`
          <button type="button" aria-pressed=${isOwn} aria-label=${`${text}: ${say("favorite")}`} onClick=${() => keep("favorites", id, !isOwn)}><${Sign} path=${isOwn ? SIGNS.star : SIGNS.starOff} /></button>
          ${!isOwn && html`<button type="button" aria-label=${`${text}: ${say("not here")}`} onClick=${() => keep("not_here", id, true)}><${Sign} path=${SIGNS.close} /></button>`}` });
      })}
    </ul></section>
    <section aria-labelledby="places"><h2 id="places">${say("Rooms")}</h2><ul class="edits">
      ${names.map((room) => {
        const mark = roomKey(room);
        const isOff = isKept("hidden", mark);
        return Row({ name: room, text: titled(room), mark, path: roomSign(room), choices: Object.keys(PLACES), icons: (one) => PLACES[one], list: "rooms", all: names, children: html`
          <button type="button" aria-pressed=${isOff} aria-label=${`${titled(room)}: ${say("hide")}`} onClick=${() => keep("hidden", mark, !isOff)}><${Sign} path=${isOff ? SIGNS.hide : SIGNS.show} /></button>` });
      })}
    </ul></section>
    ${away.length > 0 && html`<section aria-labelledby="away"><h2 id="away">${say("Hidden")}</h2><ul class="edits">${away.map((id) => html`<li key=${id} class="editrow"><span class="icon"><${Sign} path=${signOf(deviceOf(id).value)} /></span><span class="name"><bdi>${deviceOf(id).value.name}</bdi></span><span class="ways"><button type="button" aria-label=${`${deviceOf(id).value.name}: ${say("show")}`} onClick=${() => keep(isHidden(id) ? "hidden" : "not_here", id, false)}>${say("show")}</button></span></li>`)}</ul></section>`}
  </div>`;
}

const Step = ({ text, path, isOff, onClick }) => html`<button type="button" class="step" disabled=${isOff} aria-label=${text} onClick=${onClick}><${Sign} path=${path} /></button>`;
