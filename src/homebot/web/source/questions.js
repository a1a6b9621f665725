// Questions of programs: what one wants to do is done once a person says yes.
import { effect, signal } from "@preact/signals";
import { agreement } from "./acts.js";
import { ask, connection, may, missing, subscribe, token } from "./door.js";
import { html } from "./html.js";
import { say } from "./language.js";
import { HoldButton } from "./touch.js";

const questions = signal([]);
const problem = signal("");

subscribe("/control/questions", (message) => {
  questions.value = message.questions;
  problem.value = "";
});
effect(() => {
  if (connection.value.state === "connecting") questions.value = [];
});

async function answer({ question }, yes) {
  const { success, message } = await ask("/control/answer", { question, yes });
  problem.value = message;
  if (!success && !token.value) missing.value = message;
}

/** A question with a button for yes, which is held, and one for no. */
export const Question = ({ text, problem: reason, onAnswer }) => html`<section class="question" role="alert" aria-label=${say("question")}>
  <p><strong>${text}?</strong></p>
  ${may("act") && html`<p class="buttons"><${HoldButton} text=${say("do it")} onHeld=${() => onAnswer(true)} /> <button type="button" onClick=${() => onAnswer(false)}>${say("no")}</button></p>`}
  ${reason && html`<p class="bad">${reason}</p>`}
</section>`;

/** The question whether to do what the person at the page has begun and what always asks. */
export function Agreement() {
  const { text, act } = agreement.value ?? {};
  const onAnswer = (yes) => {
    agreement.value = null;
    if (yes) act();
  };
  return agreement.value && html`<div class="agreement"><${Question} text=${text} onAnswer=${onAnswer} /></div>`;
}

/** A banner for each open question. */
export const Questions = () => questions.value.map((one) => html`<${Question} key=${one.question} text=${one.text} problem=${problem.value} onAnswer=${(yes) => answer(one, yes)} />`);
