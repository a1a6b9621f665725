// Where alerts, questions and notifications go. Addresses hold passwords: homebot shows their beginning and end alone.
import { useState } from "preact/hooks";
import { ask } from "../../door.js";
import { html, written } from "../../html.js";
import { say, sayReason } from "../../language.js";
import { Remove } from "../../managing.js";
import { change, textOf, told, useTable } from "../../setting.js";
import { label } from "../../words.js";

const EXAMPLE = "ntfy://my-home";
const TEST_WITHIN = 45; // seconds: a service may take 30

export function Addresses() {
  const table = useTable("notify");
  const [added, setAdded] = useState(0);
  if (!table) return html`<p class="empty">${say("Asking homebot how it is …")}</p>`;
  const { urls = [], urls_by: by = {}, topic } = table;
  const write = (list) => (list.length || topic || Object.keys(by).length ? change(["notify"], { urls: textOf(list) }) : change([], {}, { remove: ["notify"] }));
  const add = async (event) => {
    const url = written(event).get("url").trim();
    if (await write([...urls, url])) setAdded(added + 1);
  };
  const test = async () => {
    told.value = { message: say("sending …"), success: true, isPending: true };
    const { success, message } = await ask("/alerts/test", {}, TEST_WITHIN);
    told.value = { success, message: success ? say("The test message was sent.") : sayReason(message), isPending: true };
  };
  return html`<p>${say("Alerts and questions go to phones, chats and mail by these addresses.")}</p>
    ${topic && html`<p>MQTT: <code>${topic}</code></p>`}
    ${urls.map((url) => html`<div key=${url} class="box"><code>${url}</code> <p class="choices"><${Remove} name=${url} onRemove=${() => write(urls.filter((one) => one !== url))} /></p></div>`)}
    ${Object.entries(by).map(([kind, own]) => html`<p key=${kind}>${label(kind)}: <code>${own.join(", ")}</code></p>`)}
    <form key=${added} class="fields" aria-label=${say("Address")} onSubmit=${add}>
      <label><span>${say("Address")}</span> <input name="url" autocomplete="off" spellcheck="false" required maxlength="1000" pattern=".+://.+" placeholder=${EXAMPLE} /></label>
      <p class="quiet">${say("As ntfy://TOPIC or mailto://USER:PASSWORD@HOST; appriseit.com lists all.")}</p>
      <p class="buttons"><button>${say("add")}</button> <button type="button" name="test" disabled=${!urls.length && !topic && !Object.keys(by).length} onClick=${test}>${say("send a test message")}</button></p>
    </form>`;
}
