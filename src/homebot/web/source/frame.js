// The frame around each view: the rail at the side, or the bar below; the connection, the token, questions and outcomes.
import { signal } from "@preact/signals";
import { outcome } from "./acts.js";
import { urgent, withAdded } from "./added.js";
import { connection, heardAt, missing } from "./door.js";
import { count, isLoaded, shown } from "./house.js";
import { html } from "./html.js";
import { SIGNS, Sign } from "./icons.js";
import { say } from "./language.js";
import { later, second } from "./later.js";
import { Agreement, Questions } from "./questions.js";
import { wall } from "./screen.js";
import { openOf } from "./summaries.js";
import { sheet } from "./tile.js";
import { timeText } from "./words.js";

const LogIn = second("LogIn");
const Sheet = second("Sheet");
const Wall = later(async () => (await import("./wall.js")).Wall);

/** Whether the form for a token is open. */
export const isLoggingIn = signal(false);

/** The views of the rail; on a phone the last ones are behind "More". */
export const FIRST = withAdded({ home: "Home", security: "Security", climate: "Climate" });
export const LAST = withAdded({ plan: "Plan", journal: "Journal", system: "System" });

const Link = ({ view, text, above, mark, name = "" }) => html`<a href=${`#/${view}`} class=${name} aria-current=${view === above ? "page" : undefined}><${Sign} path=${SIGNS[view]} size=${26} /><span>${say(text)}</span>${mark > 0 && html`<b>${mark}</b>`}</a>`;

export function Frame({ above, children }) {
  const { state, reason } = connection.value;
  const mustLogIn = state === "refused";
  const marks = { home: urgent().length, security: openOf(shown.value).length };
  const skip = (event) => {
    event.preventDefault();
    document.getElementById("content").focus();
  };
  return html`<div class="frame" inert=${Boolean(sheet.value)}>
      <a class="skip" href="#content" onClick=${skip}>${say("to the content")}</a>
      <nav class="rail" aria-label=${say("views")}>
        ${Object.entries(FIRST).map(([view, text]) => html`<${Link} key=${view} view=${view} text=${text} above=${above} mark=${marks[view]} />`)}
        ${Object.entries(LAST).map(([view, text]) => html`<${Link} key=${view} view=${view} text=${text} above=${above} name="last" />`)}
        <${Link} view="more" text="More" above=${above in LAST ? "more" : above} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${state === "open" ? "hidden" : "notice"}>${state === "open" ? say(count.value === 1 ? "{count} device" : "{count} devices", { count: count.value }) : mustLogIn ? say("not logged in") : reason && heardAt.value ? say("homebot cannot be reached since {time}: perhaps it is restarting.", { time: timeText({ sec: heardAt.value, nanosec: 0 }) }) : say(reason || "connecting …")}</p>
        ${(mustLogIn || isLoggingIn.value || missing.value) && html`<${LogIn} reason=${mustLogIn ? reason : missing.value} />`}
        ${isLoaded.value && !count.value && above !== "system" && html`<p class="notice"><a href="#/setup">${say("No device is there yet: set up your home.")}</a></p>`}
        <${Questions} />
        <main id="content" tabindex="-1" class=${state === "open" ? "" : "old"}>${children}</main>
      </div>
    </div>
    ${sheet.value && html`<${Sheet} />`}
    ${wall.value && html`<${Wall} />`}
    <div class="told"><${Agreement} />
      <p role="alert" class=${outcome.value ? `outcome ${outcome.value.isGood ? "good" : "bad"}` : "hidden"}>
        ${outcome.value?.text} ${outcome.value?.override && html`<button type="button" onClick=${outcome.value.override}>${say("Command it all the same?")}</button>`} ${outcome.value && !outcome.value.isGood && html`<button type="button" onClick=${() => (outcome.value = null)}>${say("close|do")}</button>`}
      </p></div>`;
}
