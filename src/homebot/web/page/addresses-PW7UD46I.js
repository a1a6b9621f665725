import{a as i,b as y,c as m,e as g}from"./chunk-JPRZ7N3P.js";import{E as $,Ga as b,W as o,a as p,n as u,v as t,w as f}from"./chunk-ISDX2PJM.js";var k="ntfy://my-home",v=45;function x(){let c=g("notify"),[l,h]=p(0);if(!c)return o`<p class="empty">${t("Asking homebot how it is \u2026")}</p>`;let{urls:a=[],urls_by:r={},topic:n}=c,d=e=>e.length||n||Object.keys(r).length?m(["notify"],{urls:y(e)}):m([],{},{remove:["notify"]}),T=async e=>{e.preventDefault();let s=new FormData(e.target).get("url").trim();await d([...a,s])&&h(l+1)},A=async()=>{i.value={message:t("sending \u2026"),success:!0,isPending:!0};let{success:e,message:s}=await u("/alerts/test",{},v);i.value={success:e,message:e?t("The test message was sent."):f(s),isPending:!0}};return o`<p>${t("Alerts and questions go to phones, chats and mail by these addresses.")}</p>
    ${n&&o`<p>MQTT: <code>${n}</code></p>`}
    ${a.map(e=>o`<div key=${e} class="box"><code>${e}</code> <p class="choices"><${b} name=${e} onRemove=${()=>d(a.filter(s=>s!==e))} /></p></div>`)}
    ${Object.entries(r).map(([e,s])=>o`<p key=${e}>${$(e)}: <code>${s.join(", ")}</code></p>`)}
    <form key=${l} class="fields" aria-label=${t("Address")} onSubmit=${T}>
      <label><span>${t("Address")}</span> <input name="url" autocomplete="off" spellcheck="false" required maxlength="1000" pattern=".+://.+" placeholder=${k} /></label>
      <p class="quiet">${t("As ntfy://TOPIC, tgram://TOKEN/CHAT or mailto://USER:PASSWORD@HOST; appriseit.com lists more than a hundred services.")}</p>
      <p class="buttons"><button>${t("add")}</button> <button type="button" name="test" disabled=${!a.length&&!n&&!Object.keys(r).length} onClick=${A}>${t("send a test message")}</button></p>
    </form>`}export{x as Addresses};
