// Questions of programs: what one wants to do is done once a person says yes.
import { effect, signal } from "@preact/signals";
import { call, connection, missing, subscribe, token } from "./door.js";
import { html } from "./html.js";
import { say } from "./language.js";

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
  try {
    const { success, message } = await call("/control/answer", { question, yes });
    problem.value = message;
    if (!success && !token.value) missing.value = message;
  } catch (error) {
    problem.value = error.message;
  }
}

/** A banner for each open question. */
export function Questions() {
  return questions.value.map(
    (one) => html`<section key=${one.question} class="box" role="alert" aria-label=${say("question")}>
      <p><strong>${one.text}?</strong></p>
      <p class="buttons"><button type="button" onClick=${() => answer(one, true)}>${say("yes, do it")}</button> <button type="button" onClick=${() => answer(one, false)}>${say("no")}</button></p>
      ${problem.value && html`<p class="bad">${problem.value}</p>`}
    </section>`,
  );
}
