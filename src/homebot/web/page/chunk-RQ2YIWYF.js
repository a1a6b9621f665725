import{b as K}from"./chunk-UV4EEYZH.js";import{a as J}from"./chunk-EFUA55MR.js";import{m as Y}from"./chunk-6ITVNAEV.js";import{c as B}from"./chunk-W54ORNDN.js";import{a as f,e as W,h as b}from"./chunk-CHSJDUJ6.js";import{m as H,n as k,u as U}from"./chunk-CMGFQJRK.js";import{d as T,k as w}from"./chunk-MZBGLNIX.js";import{c as I,d as D,e as F,g as M}from"./chunk-GVOJYK5O.js";import{C as q,F as i,I as n,c as O,d as C,h as g,j as E,n as y,p as V,q as v,v as G,w as x,x as _}from"./chunk-DKKXXYSS.js";var P=g(!1),rt=5e3;E(()=>{P.value&&y.value.state==="open"&&performance.now()>rt&&location.reload()});function h(t){let a=null;return function(r){let[,p]=O(a!==null);return C(()=>{a||t().then(o=>p((a=o)!==null),()=>P.value=!0)},[]),a&&n`<${a} ...${r} />`}}var N=g([]),Q=g(!1);_("/alerts/findings",t=>{N.value=t.findings,Q.value=t.repeats});E(()=>{y.value.state==="connecting"&&(N.value=[])});var L=()=>N.value.filter(t=>t.urgency!=="later");async function it(){let{success:t,message:a}=await x("/alerts/seen");w(t?i("Nobody is told of it again."):a,t)}function X(){let t=N.value.filter(e=>e.urgency==="later"),a=L();return n`
    ${a.map((e,r)=>n`<section key=${e.code} class="banner alarm" role="alert"><${b} path=${f.alert} size=${48} />
        <div>
          <h2>${i(e.title||"problem")}</h2>
          ${e.rows.map(p=>n`<p key=${p.what+p.why}>${k(p.what)&&n`<button type="button" class="link" onClick=${()=>B(p.what)}>${U(p.what)}</button>`} ${(q.value==="en"||!p.what)&&p.why}</p>`)}
          ${e.next&&n`<p><strong>${i(e.next)}</strong></p>`}
        </div>
        ${r===a.length-1&&Q.value&&v("act")&&n`<button type="button" class="seen" onClick=${it}><${b} path=${f.check} /> ${i("I have seen it")}</button>`}
      </section>`)}
    ${t.length>0&&n`<p class="notes"><a href="#/system">${t.map(e=>`${i(e.title)}: ${e.total}`).join(" \xB7 ")}</a></p>`}`}var Z={parts:{top:X},urgent:L};var tt={parts:{routines:h(async()=>(await import("./habits-ILB63VRJ.js")).Habits)}};var lt=({devices:t,Chip:a})=>t.some(e=>[...e.states.values()].some(r=>r.capability==="power"))&&n`<${a} view="energy" sign=${f.energy} text=${M("power",Math.round(Y(t)))} tone="on" />`,et={views:{energy:{title:"Energy",View:h(async()=>(await import("./energy-6OJJVTU5.js")).Energy),after:"climate",hasHead:!0}},parts:{chips:lt,day:J,device:h(async()=>(await import("./history-5OZSZCF3.js")).History)}};var at={views:{routines:{title:"Routines",View:h(async()=>(await import("./routines-CVBM35JR.js")).Routines),after:"plan"}}};var pt=300,nt=g([]),R=()=>G("/scenes/list").then(t=>nt.value=t.scenes,()=>{});async function z(t,a){w(`${t.name}: \u2026`,!0);let{success:e,message:r,results:p=[]}=await x("/scenes/apply",{name:t.id,...a},pt);V.value=p.find(o=>o.result.policy==="rights")?.result.reason??"",w(`${t.name}: ${r||i(a.undo?"undone":"done")}`,e),R()}async function S(t,a,e){let{success:r,message:p,left_out:o=[]}=await x("/scenes/change",{name:t,change:a,...e}),m=[p,...o.map(c=>`${c.key}: ${c.value}`)].filter(Boolean);return w(`${t}: ${m.join("; ")||i(a==="remove"?"removed":"saved")}`,r),R(),r}function st({room:t}){let[a,e]=O(null),r=y.value.state==="open";C(()=>{r&&R()},[r]);let p=s=>[s.area,...s.parts.map(u=>u.area)].some(u=>u.toLowerCase()===t.toLowerCase()),o=nt.value.filter(s=>t===void 0?!s.is_native:p(s)),m=s=>()=>e(s===a?null:s),c=()=>e(null),l=s=>{let u=s.parts.filter($=>$.asks).map($=>`${I($.name)} ${$.text} (${$.asks})`);u.length?T(`${s.name}: ${u.join(", ")}`,()=>z(s,{agreed:!0})):z(s,{})},d=o.find(s=>s.id===a);return n`
    <div class="scenes" role="group" aria-label=${i("scenes")}>
      ${o.map(s=>n`<span key=${s.id} class="scene">
        <button type="button" disabled=${!v("act")} onClick=${()=>l(s)}><${b} path=${W(s.name)} size=${22} /> <bdi>${s.name}</bdi></button>
        ${s.can_undo&&v("act")&&n`<button type="button" aria-label=${i("undo {name}",{name:s.name})} onClick=${()=>z(s,{undo:!0})}><${b} path=${f.undo} size=${20} /></button>`}
        <button type="button" aria-expanded=${s.id===a} aria-label=${i("more of {name}",{name:s.name})} onClick=${m(s.id)}><${b} path=${f.more} size=${20} /></button>
      </span>`)}
      ${v("manage")&&n`<button type="button" class="new" aria-expanded=${a==="new"} onClick=${m("new")}><${b} path=${f.plus} size=${20} /> ${F(i("new scene"))}</button>`}
    </div>
    ${a==="new"&&n`<${mt} room=${t} onClose=${c} />`}
    ${d&&n`<${ct} key=${d.id} scene=${d} onClose=${c} />`}`}function mt({room:t,onClose:a}){let e=async o=>{o.preventDefault();let m=new FormData(o.target),c=m.getAll("device").map(l=>({key:l,value:"now"}));await S(m.get("name").trim(),"save",{values:c})&&a()},r=o=>k(o).value.settable.length&&k(o).value.states.size,p=H.value.map(([o,m])=>[o,m.filter(r)]).filter(([,o])=>o.length);return n`<form class="card fields" aria-label=${i("new scene")} onSubmit=${e}>
    <label><span>${i("Name")}</span> <input name="name" required maxlength="100" /></label>
    <p>${i("It keeps the present values of:")}</p>
    <div class="columns">${p.map(([o,m])=>n`<details key=${o} open=${t!==void 0&&o.toLowerCase()===t.toLowerCase()}>
      <summary>${o?D(o):i("Without a room")}</summary>
      ${m.map(c=>n`<label key=${c}><input type="checkbox" name="device" value=${c} /> <bdi>${k(c).value.name}</bdi></label>`)}
    </details>`)}</div>
    <p class="buttons"><button>${i("save")}</button> <button type="button" onClick=${a}>${i("not now")}</button></p>
  </form>`}function ct({scene:t,onClose:a}){let{name:e,parts:r,problems:p}=t,o=v("manage")&&!t.is_native&&!t.is_configured,m=l=>l.part?`${l.device}#${l.part}`:l.device;return n`<form class="card fields" aria-label=${e} onSubmit=${async l=>{l.preventDefault();let d=new FormData(l.target),s=r.map(($,j)=>({key:m($),value:d.get(`value${j}`).trim()})).filter(({value:$},j)=>$!==r[j].text);if(s.length&&!await S(e,"edit",{values:s}))return;let u=d.get("name").trim();(u===e||await S(e,"rename",{target:u}))&&a()}}>
    <h3><bdi>${e}</bdi></h3>
    ${o&&n`<label><span>${i("Name")}</span> <input name="name" required maxlength="100" defaultValue=${e} /></label>`}
    ${r.map((l,d)=>n`<label key=${m(l)}><span><bdi>${I(l.name)}</bdi></span> ${o?n`<input name=${`value${d}`} defaultValue=${l.text} />`:l.text} ${l.asks&&n`<small>${l.asks}</small>`}</label>`)}
    ${p.map(l=>n`<p key=${l.key} class="bad">${l.key}: ${l.value}</p>`)}
    ${!r.length&&n`<p class="quiet">${i("What keeps this scene does not tell its values.")}</p>`}
    ${o&&n`<p class="quiet">${i("A device without a value is left out.")}</p>`}
    <p class="buttons">
      ${o&&n`<button>${i("save")}</button>
        <button type="button" onClick=${()=>S(e,"save").then(a)}>${i("take the present values")}</button>
        <${K} name=${e} onRemove=${()=>S(e,"remove").then(a)} />`}
      <button type="button" onClick=${a}>${i("close|do")}</button>
    </p>
  </form>`}var ot={parts:{scenes:st}};var A=[Z,tt,et,at,ot];var ut=Object.assign({},...A.map(({views:t})=>t)),ie=({at:t,...a})=>A.map(({parts:e})=>e?.[t]&&n`<${e[t]} ...${a} />`),le=()=>A.flatMap(t=>t.urgent?.()??[]);function pe(t){let a=e=>Object.entries(ut).filter(([,{after:r}])=>r===e).map(([r,{title:p}])=>[r,p]);return Object.fromEntries(Object.entries(t).flatMap(([e,r])=>[[e,r],...a(e)]))}export{h as a,ut as b,ie as c,le as d,pe as e};
