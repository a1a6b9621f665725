import"./chunk-HJ5TEVRD.js";import{$ as w,A as a,E as k,F as y,Ga as _,Ia as q,aa as s,ib as D,ka as x,la as c,m as g,s as h}from"./chunk-VQMOVCEH.js";async function p(l,o,n){let{success:m,message:u,left_out:e=[]}=await h("/scenes/change",{name:l,change:o,...n}),i=[u,...e.map(r=>`${r.key}: ${r.value}`)].filter(Boolean);return w(`${l}: ${i.join("; ")||a(o==="remove"?"removed":"saved")}`,m),D(),m}function V({room:l,onClose:o}){let n=async e=>{e.preventDefault();let i=new FormData(e.target),r=i.getAll("device").map(t=>({key:t,value:"now"}));await p(i.get("name").trim(),"save",{values:r})&&o()},m=e=>c(e).value.settable.length&&c(e).value.states.size,u=x.value.map(([e,i])=>[e,i.filter(m)]).filter(([,e])=>e.length);return s`<form class="card fields" aria-label=${a("new scene")} onSubmit=${n}>
    <label><span>${a("Name")}</span> <input name="name" required maxlength="100" /></label>
    <p>${a("It keeps the present values of:")}</p>
    <div class="columns">${u.map(([e,i])=>s`<details key=${e} open=${l!==void 0&&e.toLowerCase()===l.toLowerCase()}>
      <summary>${e?y(e):a("Without a room")}</summary>
      ${i.map(r=>s`<label key=${r}><input type="checkbox" name="device" value=${r} /> <bdi>${c(r).value.name}</bdi></label>`)}
    </details>`)}</div>
    <p class="buttons"><button>${a("save")}</button> <button type="button" onClick=${o}>${a("not now")}</button></p>
  </form>`}function W({scene:l,onClose:o}){let{name:n,parts:m,problems:u}=l,e=g("manage")&&!l.is_native&&!l.is_configured,i=t=>t.part?`${t.device}#${t.part}`:t.device;return s`<form class="card fields" aria-label=${n} onSubmit=${async t=>{t.preventDefault();let $=new FormData(t.target),f=m.map((b,v)=>({key:i(b),value:$.get(`value${v}`).trim()})).filter(({value:b},v)=>b!==m[v].text);if(f.length&&!await p(n,"edit",{values:f}))return;let d=$.get("name").trim();(d===n||await p(n,"rename",{target:d}))&&o()}}>
    <h3><bdi>${n}</bdi></h3>
    ${e&&s`<label><span>${a("Name")}</span> <input name="name" required maxlength="100" defaultValue=${n} /></label>`}
    ${m.map((t,$)=>s`<label key=${i(t)}><span><bdi>${k(t.name)}</bdi></span> ${e?s`<input name=${`value${$}`} defaultValue=${t.text} />`:t.text} ${t.asks&&s`<small>${t.asks}</small>`}</label>`)}
    ${u.map(t=>s`<p key=${t.key} class="bad">${t.key}: ${t.value}</p>`)}
    ${!m.length&&s`<p class="quiet">${a("What keeps this scene does not tell its values.")}</p>`}
    ${e&&s`<p class="quiet">${a("A device without a value is left out.")}</p>`}
    ${!l.is_native&&!l.is_configured&&s`<${_} right="manage" />`}
    <p class="buttons">
      ${e&&s`<button>${a("save")}</button>
        <button type="button" onClick=${()=>p(n,"save").then(o)}>${a("take the present values")}</button>
        <${q} name=${n} onRemove=${()=>p(n,"remove").then(o)} />`}
      <button type="button" onClick=${o}>${a("close|do")}</button>
    </p>
  </form>`}export{V as NewScene,W as OneScene};
