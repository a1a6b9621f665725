import{b as K}from"./chunk-ULDDBBAG.js";import{a as J}from"./chunk-NVSM3RAQ.js";import{m as Y}from"./chunk-QBZ6BA7O.js";import{c as B}from"./chunk-GLCKL2HZ.js";import{a as f,e as W,h as b}from"./chunk-N2Y6UGSU.js";import{m as H,n as w,u as U}from"./chunk-ZPSP65LU.js";import{d as T,k}from"./chunk-RMSJOTTF.js";import{c as I,d as D,e as F,g as M}from"./chunk-BEVGLSVT.js";import{C as q,F as i,I as n,c as O,d as C,h as g,j as E,n as y,p as V,q as v,v as G,w as x,x as _}from"./chunk-UMKYRW5X.js";var P=g(!1),re=5e3;E(()=>{P.value&&y.value.state==="open"&&performance.now()>re&&location.reload()});function h(e){let a=null;return function(r){let[,m]=O(a!==null);return C(()=>{a||e().then(o=>m((a=o)!==null),()=>P.value=!0)},[]),a&&n`<${a} ...${r} />`}}var N=g([]),Q=g(!1);_("/alerts/findings",e=>{N.value=e.findings,Q.value=e.repeats});E(()=>{y.value.state==="connecting"&&(N.value=[])});var L=()=>N.value.filter(e=>e.urgency!=="later");async function ie(){let{success:e,message:a}=await x("/alerts/seen");k(e?i("Nobody is told of it again."):a,e)}function X(){let e=N.value.filter(t=>t.urgency==="later"),a=L();return n`
    ${a.map((t,r)=>n`<section key=${t.code} class="banner alarm" role="alert"><${b} path=${f.alert} size=${48} />
        <div>
          <h2>${i(t.title||"problem")}</h2>
          ${t.rows.map(m=>n`<p key=${m.what+m.why}>${w(m.what)&&n`<button type="button" class="link" onClick=${()=>B(m.what)}>${U(m.what)}</button>`} ${(q.value==="en"||!m.what)&&m.why}</p>`)}
          ${t.next&&n`<p><strong>${i(t.next)}</strong></p>`}
        </div>
        ${r===a.length-1&&Q.value&&v("act")&&n`<button type="button" class="seen" onClick=${ie}><${b} path=${f.check} /> ${i("I have seen it")}</button>`}
      </section>`)}
    ${e.length>0&&n`<p class="notes"><a href="#/system">${e.map(t=>`${i(t.title)}: ${t.total}`).join(" \xB7 ")}</a></p>`}`}var Z={parts:{top:X},marks:{home:()=>L().length}};var ee={parts:{routines:h(async()=>(await import("./habits-QV3UMKXB.js")).Habits)}};var le=({devices:e,Chip:a})=>e.some(t=>[...t.states.values()].some(r=>r.capability==="power"))&&n`<${a} view="energy" sign=${f.energy} text=${M("power",Math.round(Y(e)))} tone="on" />`,te={views:{energy:{title:"Energy",View:h(async()=>(await import("./energy-CFXPKZ5Z.js")).Energy),after:"climate",hasHead:!0}},parts:{chips:le,day:J,device:h(async()=>(await import("./history-SJJE3KL3.js")).History)}};var ae={views:{routines:{title:"Routines",View:h(async()=>(await import("./routines-IKQAXNRA.js")).Routines),after:"plan"}}};var me=300,ne=g([]),R=()=>G("/scenes/list").then(e=>ne.value=e.scenes,()=>{});async function z(e,a){k(`${e.name}: \u2026`,!0);let{success:t,message:r,results:m=[]}=await x("/scenes/apply",{name:e.id,...a},me);V.value=m.find(o=>o.result.policy==="rights")?.result.reason??"",k(`${e.name}: ${r||i(a.undo?"undone":"done")}`,t),R()}async function S(e,a,t){let{success:r,message:m,left_out:o=[]}=await x("/scenes/change",{name:e,change:a,...t}),p=[m,...o.map(c=>`${c.key}: ${c.value}`)].filter(Boolean);return k(`${e}: ${p.join("; ")||i(a==="remove"?"removed":"saved")}`,r),R(),r}function se({room:e}){let[a,t]=O(null),r=y.value.state==="open";C(()=>{r&&R()},[r]);let m=s=>[s.area,...s.parts.map(u=>u.area)].some(u=>u.toLowerCase()===e.toLowerCase()),o=ne.value.filter(s=>e===void 0?!s.is_native:m(s)),p=s=>()=>t(s===a?null:s),c=()=>t(null),l=s=>{let u=s.parts.filter($=>$.asks).map($=>`${I($.name)} ${$.text} (${$.asks})`);u.length?T(`${s.name}: ${u.join(", ")}`,()=>z(s,{agreed:!0})):z(s,{})},d=o.find(s=>s.id===a);return n`
    <div class="scenes" role="group" aria-label=${i("scenes")}>
      ${o.map(s=>n`<span key=${s.id} class="scene">
        <button type="button" disabled=${!v("act")} onClick=${()=>l(s)}><${b} path=${W(s.name)} size=${22} /> <bdi>${s.name}</bdi></button>
        ${s.can_undo&&v("act")&&n`<button type="button" aria-label=${i("undo {name}",{name:s.name})} onClick=${()=>z(s,{undo:!0})}><${b} path=${f.undo} size=${20} /></button>`}
        <button type="button" aria-expanded=${s.id===a} aria-label=${i("more of {name}",{name:s.name})} onClick=${p(s.id)}><${b} path=${f.more} size=${20} /></button>
      </span>`)}
      ${v("manage")&&n`<button type="button" class="new" aria-expanded=${a==="new"} onClick=${p("new")}><${b} path=${f.plus} size=${20} /> ${F(i("new scene"))}</button>`}
    </div>
    ${a==="new"&&n`<${pe} room=${e} onClose=${c} />`}
    ${d&&n`<${ce} key=${d.id} scene=${d} onClose=${c} />`}`}function pe({room:e,onClose:a}){let t=async o=>{o.preventDefault();let p=new FormData(o.target),c=p.getAll("device").map(l=>({key:l,value:"now"}));await S(p.get("name").trim(),"save",{values:c})&&a()},r=o=>w(o).value.settable.length&&w(o).value.states.size,m=H.value.map(([o,p])=>[o,p.filter(r)]).filter(([,o])=>o.length);return n`<form class="card fields" aria-label=${i("new scene")} onSubmit=${t}>
    <label><span>${i("Name")}</span> <input name="name" required maxlength="100" /></label>
    <p>${i("It keeps the present values of:")}</p>
    <div class="columns">${m.map(([o,p])=>n`<details key=${o} open=${e!==void 0&&o.toLowerCase()===e.toLowerCase()}>
      <summary>${o?D(o):i("Without a room")}</summary>
      ${p.map(c=>n`<label key=${c}><input type="checkbox" name="device" value=${c} /> <bdi>${w(c).value.name}</bdi></label>`)}
    </details>`)}</div>
    <p class="buttons"><button>${i("save")}</button> <button type="button" onClick=${a}>${i("not now")}</button></p>
  </form>`}function ce({scene:e,onClose:a}){let{name:t,parts:r,problems:m}=e,o=v("manage")&&!e.is_native&&!e.is_configured,p=l=>l.part?`${l.device}#${l.part}`:l.device;return n`<form class="card fields" aria-label=${t} onSubmit=${async l=>{l.preventDefault();let d=new FormData(l.target),s=r.map(($,j)=>({key:p($),value:d.get(`value${j}`).trim()})).filter(({value:$},j)=>$!==r[j].text);if(s.length&&!await S(t,"edit",{values:s}))return;let u=d.get("name").trim();(u===t||await S(t,"rename",{target:u}))&&a()}}>
    <h3><bdi>${t}</bdi></h3>
    ${o&&n`<label><span>${i("Name")}</span> <input name="name" required maxlength="100" defaultValue=${t} /></label>`}
    ${r.map((l,d)=>n`<label key=${p(l)}><span><bdi>${I(l.name)}</bdi></span> ${o?n`<input name=${`value${d}`} defaultValue=${l.text} />`:l.text} ${l.asks&&n`<small>${l.asks}</small>`}</label>`)}
    ${m.map(l=>n`<p key=${l.key} class="bad">${l.key}: ${l.value}</p>`)}
    ${!r.length&&n`<p class="quiet">${i("What keeps this scene does not tell its values.")}</p>`}
    ${o&&n`<p class="quiet">${i("A device without a value is left out.")}</p>`}
    <p class="buttons">
      ${o&&n`<button>${i("save")}</button>
        <button type="button" onClick=${()=>S(t,"save").then(a)}>${i("take the present values")}</button>
        <${K} name=${t} onRemove=${()=>S(t,"remove").then(a)} />`}
      <button type="button" onClick=${a}>${i("close|do")}</button>
    </p>
  </form>`}var oe={parts:{scenes:se}};var A=[Z,ee,te,ae,oe];var ue=Object.assign({},...A.map(({views:e})=>e)),it=({at:e,...a})=>A.map(({parts:t})=>t?.[e]&&n`<${t[e]} ...${a} />`),lt=e=>A.reduce((a,{marks:t})=>a+(t?.[e]?.()??0),0);function mt(e){let a=t=>Object.entries(ue).filter(([,{after:r}])=>r===t).map(([r,{title:m}])=>[r,m]);return Object.fromEntries(Object.entries(e).flatMap(([t,r])=>[[t,r],...a(t)]))}export{h as a,ue as b,it as c,lt as d,mt as e};
