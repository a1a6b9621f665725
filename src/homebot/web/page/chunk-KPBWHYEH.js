import{b as K}from"./chunk-UV4EEYZH.js";import{a as J}from"./chunk-EFUA55MR.js";import{c as B}from"./chunk-23RNGWL3.js";import{m as Y}from"./chunk-NVFS5PHO.js";import{a as f,e as W,h as b}from"./chunk-VTZC2C7Y.js";import{m as H,n as w,u as U}from"./chunk-CMGFQJRK.js";import{d as z,k}from"./chunk-MZBGLNIX.js";import{c as N,d as F,e as M,g as T}from"./chunk-GVOJYK5O.js";import{C as D,F as i,I as n,c as O,d as C,h as g,j as E,n as y,p as _,q as v,v as G,w as x,x as q}from"./chunk-DKKXXYSS.js";var P=g(!1),re=5e3;E(()=>{P.value&&y.value.state==="open"&&performance.now()>re&&location.reload()});function h(e){let a=null;return function(r){let[,m]=O(a!==null);return C(()=>{a||e().then(s=>m((a=s)!==null),()=>P.value=!0)},[]),a&&n`<${a} ...${r} />`}}var j=g([]),Q=g(!1);q("/alerts/findings",e=>{j.value=e.findings,Q.value=e.repeats});E(()=>{y.value.state==="connecting"&&(j.value=[])});var R=()=>j.value.filter(e=>e.urgency!=="later");async function ie(){let{success:e,message:a}=await x("/alerts/seen");k(e?i("Nobody is told of it again."):a,e)}function X(){let e=j.value.filter(t=>t.urgency==="later"),a=R();return n`
    ${a.map((t,r)=>n`<section key=${t.code} class="banner alarm" role="alert"><${b} path=${f.alert} size=${48} />
        <div>
          <h2>${i(t.title||"problem")}</h2>
          ${t.rows.map(m=>n`<p key=${m.what+m.why}>${w(m.what)&&n`<button type="button" class="link" onClick=${()=>B(m.what)}>${U(m.what)}</button>`} ${(D.value==="en"||!m.what)&&m.why}</p>`)}
          ${t.next&&n`<p><strong>${i(t.next)}</strong></p>`}
        </div>
        ${r===a.length-1&&Q.value&&v("act")&&n`<button type="button" class="seen" onClick=${ie}><${b} path=${f.check} /> ${i("I have seen it")}</button>`}
      </section>`)}
    ${e.length>0&&n`<p class="notes"><a href="#/system">${e.map(t=>`${i(t.title)}: ${t.total}`).join(" \xB7 ")}</a></p>`}`}var Z={parts:{top:X},urgent:R};var ee={parts:{routines:h(async()=>(await import("./habits-ILB63VRJ.js")).Habits)}};var le=({devices:e,Chip:a})=>e.some(t=>[...t.states.values()].some(r=>r.capability==="power"))&&n`<${a} view="energy" sign=${f.energy} text=${T("power",Math.round(Y(e)))} tone="on" />`,te={views:{energy:{title:"Energy",View:h(async()=>(await import("./energy-KZKJLI3Y.js")).Energy),after:"climate",hasHead:!0}},parts:{chips:le,day:J,device:h(async()=>(await import("./history-5OZSZCF3.js")).History)}};var ae={views:{routines:{title:"Routines",View:h(async()=>(await import("./routines-352EUI2B.js")).Routines),after:"plan"}}};var me=300,ne=g([]),V=()=>G("/scenes/list").then(e=>ne.value=e.scenes,()=>{});async function A(e,a){k(`${e.name}: \u2026`,!0);let{success:t,message:r,results:m=[],asks:s=[]}=await x("/scenes/apply",{name:e.id,...a},me);if(s.length){z(`${i("undo {name}",{name:e.name})}: ${s.map(p=>`${N(p.key)} (${p.value})`).join(", ")}`,()=>A(e,{undo:!0,agreed:!0}));return}_.value=m.find(p=>p.result.policy==="rights")?.result.reason??"",k(`${e.name}: ${r||i(a.undo?"undone":"done")}`,t),V()}async function S(e,a,t){let{success:r,message:m,left_out:s=[]}=await x("/scenes/change",{name:e,change:a,...t}),p=[m,...s.map(u=>`${u.key}: ${u.value}`)].filter(Boolean);return k(`${e}: ${p.join("; ")||i(a==="remove"?"removed":"saved")}`,r),V(),r}function se({room:e}){let[a,t]=O(null),r=y.value.state==="open";C(()=>{r&&V()},[r]);let m=o=>[o.area,...o.parts.map(c=>c.area)].some(c=>c.toLowerCase()===e.toLowerCase()),s=ne.value.filter(o=>e===void 0?!o.is_native:m(o)),p=o=>()=>t(o===a?null:o),u=()=>t(null),l=o=>{let c=o.parts.filter($=>$.asks).map($=>`${N($.name)} ${$.text} (${$.asks})`);c.length?z(`${o.name}: ${c.join(", ")}`,()=>A(o,{agreed:!0})):A(o,{})},d=s.find(o=>o.id===a);return n`
    <div class="scenes" role="group" aria-label=${i("scenes")}>
      ${s.map(o=>n`<span key=${o.id} class="scene">
        <button type="button" disabled=${!v("act")} onClick=${()=>l(o)}><${b} path=${W(o.name)} size=${22} /> <bdi>${o.name}</bdi></button>
        ${o.can_undo&&v("act")&&n`<button type="button" aria-label=${i("undo {name}",{name:o.name})} onClick=${()=>A(o,{undo:!0,unless_asks:!0})}><${b} path=${f.undo} size=${20} /></button>`}
        <button type="button" aria-expanded=${o.id===a} aria-label=${i("more of {name}",{name:o.name})} onClick=${p(o.id)}><${b} path=${f.more} size=${20} /></button>
      </span>`)}
      ${v("manage")&&n`<button type="button" class="new" aria-expanded=${a==="new"} onClick=${p("new")}><${b} path=${f.plus} size=${20} /> ${M(i("new scene"))}</button>`}
    </div>
    ${a==="new"&&n`<${pe} room=${e} onClose=${u} />`}
    ${d&&n`<${ue} key=${d.id} scene=${d} onClose=${u} />`}`}function pe({room:e,onClose:a}){let t=async s=>{s.preventDefault();let p=new FormData(s.target),u=p.getAll("device").map(l=>({key:l,value:"now"}));await S(p.get("name").trim(),"save",{values:u})&&a()},r=s=>w(s).value.settable.length&&w(s).value.states.size,m=H.value.map(([s,p])=>[s,p.filter(r)]).filter(([,s])=>s.length);return n`<form class="card fields" aria-label=${i("new scene")} onSubmit=${t}>
    <label><span>${i("Name")}</span> <input name="name" required maxlength="100" /></label>
    <p>${i("It keeps the present values of:")}</p>
    <div class="columns">${m.map(([s,p])=>n`<details key=${s} open=${e!==void 0&&s.toLowerCase()===e.toLowerCase()}>
      <summary>${s?F(s):i("Without a room")}</summary>
      ${p.map(u=>n`<label key=${u}><input type="checkbox" name="device" value=${u} /> <bdi>${w(u).value.name}</bdi></label>`)}
    </details>`)}</div>
    <p class="buttons"><button>${i("save")}</button> <button type="button" onClick=${a}>${i("not now")}</button></p>
  </form>`}function ue({scene:e,onClose:a}){let{name:t,parts:r,problems:m}=e,s=v("manage")&&!e.is_native&&!e.is_configured,p=l=>l.part?`${l.device}#${l.part}`:l.device;return n`<form class="card fields" aria-label=${t} onSubmit=${async l=>{l.preventDefault();let d=new FormData(l.target),o=r.map(($,L)=>({key:p($),value:d.get(`value${L}`).trim()})).filter(({value:$},L)=>$!==r[L].text);if(o.length&&!await S(t,"edit",{values:o}))return;let c=d.get("name").trim();(c===t||await S(t,"rename",{target:c}))&&a()}}>
    <h3><bdi>${t}</bdi></h3>
    ${s&&n`<label><span>${i("Name")}</span> <input name="name" required maxlength="100" defaultValue=${t} /></label>`}
    ${r.map((l,d)=>n`<label key=${p(l)}><span><bdi>${N(l.name)}</bdi></span> ${s?n`<input name=${`value${d}`} defaultValue=${l.text} />`:l.text} ${l.asks&&n`<small>${l.asks}</small>`}</label>`)}
    ${m.map(l=>n`<p key=${l.key} class="bad">${l.key}: ${l.value}</p>`)}
    ${!r.length&&n`<p class="quiet">${i("What keeps this scene does not tell its values.")}</p>`}
    ${s&&n`<p class="quiet">${i("A device without a value is left out.")}</p>`}
    <p class="buttons">
      ${s&&n`<button>${i("save")}</button>
        <button type="button" onClick=${()=>S(t,"save").then(a)}>${i("take the present values")}</button>
        <${K} name=${t} onRemove=${()=>S(t,"remove").then(a)} />`}
      <button type="button" onClick=${a}>${i("close|do")}</button>
    </p>
  </form>`}var oe={parts:{scenes:se}};var I=[Z,ee,te,ae,oe];var ce=Object.assign({},...I.map(({views:e})=>e)),it=({at:e,...a})=>I.map(({parts:t})=>t?.[e]&&n`<${t[e]} ...${a} />`),lt=()=>I.flatMap(e=>e.urgent?.()??[]);function mt(e){let a=t=>Object.entries(ce).filter(([,{after:r}])=>r===t).map(([r,{title:m}])=>[r,m]);return Object.fromEntries(Object.entries(e).flatMap(([t,r])=>[[t,r],...a(t)]))}export{h as a,ce as b,it as c,lt as d,mt as e};
