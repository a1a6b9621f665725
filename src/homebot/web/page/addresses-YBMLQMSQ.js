import{a as i,b as y,c as l,e as g}from"./chunk-QWYIVUT5.js";import"./chunk-HJ5TEVRD.js";import{A as t,B as f,Ia as b,J as $,a as d,aa as o,s as u}from"./chunk-VQMOVCEH.js";var k="ntfy://my-home",v=45;function E(){let c=g("notify"),[m,h]=d(0);if(!c)return o`<p class="empty">${t("Asking homebot how it is \u2026")}</p>`;let{urls:a=[],urls_by:r={},topic:n}=c,p=e=>e.length||n||Object.keys(r).length?l(["notify"],{urls:y(e)}):l([],{},{remove:["notify"]}),A=async e=>{e.preventDefault();let s=new FormData(e.target).get("url").trim();await p([...a,s])&&h(m+1)},T=async()=>{i.value={message:t("sending \u2026"),success:!0,isPending:!0};let{success:e,message:s}=await u("/alerts/test",{},v);i.value={success:e,message:e?t("The test message was sent."):f(s),isPending:!0}};return o`<p>${t("Alerts and questions go to phones, chats and mail by these addresses.")}</p>
    ${n&&o`<p>MQTT: <code>${n}</code></p>`}
    ${a.map(e=>o`<div key=${e} class="box"><code>${e}</code> <p class="choices"><${b} name=${e} onRemove=${()=>p(a.filter(s=>s!==e))} /></p></div>`)}
    ${Object.entries(r).map(([e,s])=>o`<p key=${e}>${$(e)}: <code>${s.join(", ")}</code></p>`)}
    <form key=${m} class="fields" aria-label=${t("Address")} onSubmit=${A}>
      <label><span>${t("Address")}</span> <input name="url" autocomplete="off" spellcheck="false" required maxlength="1000" pattern=".+://.+" placeholder=${k} /></label>
      <p class="quiet">${t("As ntfy://TOPIC or mailto://USER:PASSWORD@HOST; appriseit.com lists all.")}</p>
      <p class="buttons"><button>${t("add")}</button> <button type="button" name="test" disabled=${!a.length&&!n&&!Object.keys(r).length} onClick=${T}>${t("send a test message")}</button></p>
    </form>`}export{E as Addresses};
