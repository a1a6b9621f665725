import{a as F,b as q}from"./chunk-DIBDR3YO.js";import{d as A,k as v}from"./chunk-YB32CKE5.js";import{c as O,o as b,t as x,u as w,v as j}from"./chunk-Q45TKNX5.js";import{C as N,F as n,I as e,c as g,d as E,f as I,n as _,q as y,v as R,w as k}from"./chunk-E5CCYWQY.js";var z=300,M={parts:{routines:J}};function J({zone:t,onChange:l}){let[s,c]=g(null),o=async()=>{c({proposals:[],isSearching:!0}),c({proposals:[],...await k("/habits/suggest",{},z)})},a=async(r,$)=>{let{success:d,message:f}=await k("/habits/decide",{id:r,accept:$},z);v(f,d),d&&c(C=>({...C,proposals:C.proposals.filter(G=>G.id!==r)})),l()},{proposals:p=[],watched:i=[],isSearching:m,success:u,message:h}=s??{};return e`
    <h2>${n("Your habits")}</h2>
    <p class="choices"><button type="button" disabled=${m} onClick=${o}>${n(m?"searching \u2026":"look for habits")}</button> <small>${n("homebot looks in the history of four weeks for what you do again and again, and watches that for a week before it proposes it.")}</small></p>
    ${h&&e`<p class="bad">${h}</p>`}
    ${u&&!p.length&&e`<p class="empty">${n("There is nothing to propose.")}</p>`}
    ${i.map(r=>e`<p class="quiet" key=${r}>${n("watching: {name}",{name:r})}</p>`)}
    <div class="columns">${p.map(r=>e`<${U} key=${r.id} proposal=${r} zone=${t} decide=${a} />`)}</div>`}function U({proposal:t,zone:l,decide:s}){let{id:c,removes:o,name:a,when:p,conditions:i,occasions:m,proof:u}=t,h=N.value==="en"||o?u:n("In the week of the trial you did this {done} of {total} times; a routine would be right {low} to {high} % of the time.",{done:t.trial_done,total:t.trial_total,low:Math.round(100*t.precision_low),high:Math.round(100*t.precision_high)});return e`<section>
    <h3>${o?n("remove {name}",{name:o}):e`<bdi>${a}</bdi>`}</h3>
    ${!o&&e`<${S} of=${{when:[p],conditions:i,steps:[t.do]}} />`}
    <p>${h}</p>
    ${m.length>0&&e`<details><summary>${n("each time")}</summary>
      <ol class="log">${[...m].reverse().map(r=>e`<li class="own" key=${b(r.at)}><time>${w(l,r.at)}</time><span class=${b(r.done_at)?"":"bad"}>${W(r)}</span></li>`)}</ol>
    </details>`}
    ${y("manage")&&e`<p class="choices"><button type="button" onClick=${()=>s(c,!0)}>${n(o?"remove":"accept")}</button> <button type="button" onClick=${()=>s(c,!1)}>${n(o?"keep":"reject")}</button></p>`}
  </section>`}function W({at:t,done_at:l}){if(!b(l))return n("you did not");let s=b(l)-b(t);return n(s<0?"you did it {time} before":"you did it {time} later",{time:j(Math.abs(s))})}var P=[M];var H=5e3,D=["single","restart","queued","parallel"];function ht(){let[t,l]=g(null),[s,c]=g(null),o=_.value.state==="open",a=()=>R("/routines/list",{check:!0}).then(l,i=>l({routines:[],problem:i.message}));E(()=>{if(!o)return;a();let i=setInterval(a,H);return()=>clearInterval(i)},[o]);let p=async(i,m,u)=>{let h={name:i.name,change:m,...u},r=await k("/routines/change",{...h,unless_asks:!0});if(r.asks?.length){let $=r.asks.map(({key:d,value:f})=>O(d)+(f&&` (${f})`)).join(", ");await new Promise(d=>A(m==="run"?`${i.name}: ${$}`:n("let this routine command {names}",{names:$}),d)),r=await k("/routines/change",h)}return(r.success||!u?.text)&&v(r.message,r.success),a(),r};return t?e`
    ${t.problem&&e`<p class="bad">${t.problem}</p>`}
    ${!t.routines.length&&e`<p class="empty">${n("There is no routine yet.")}</p>`}
    <${F}>${!s&&e`<p class="choices"><button type="button" onClick=${()=>c({})}>${n("new routine")}</button></p>`}<//>
    ${s&&e`<${Y} key=${s.name??""} routine=${s} change=${p} onClose=${()=>c(null)} />`}
    <div class="columns">${t.routines.map(i=>e`<${K} key=${i.app} routine=${i} zone=${t.zone} change=${p} onEdit=${()=>c(i)} />`)}</div>
    ${P.map(({parts:i})=>i?.routines&&e`<${i.routines} zone=${t.zone} onChange=${a} />`)}`:e`<p class="empty">${n("Asking homebot for its routines \u2026")}</p>`}function K({routine:t,zone:l,change:s,onEdit:c}){let{name:o,notes:a,is_kept:p,proposed_by:i}=t;return e`<section>
    <div class="title">
      <h2><bdi>${o}</bdi></h2>
      ${t.is_running&&e`<span class="mark">${n("running")}</span>`}
      ${i&&e`<span class="mark">${n("proposed by {name}",{name:i})}</span>`}
      <button type="button" class="switch" role="switch" aria-checked=${String(t.enabled&&!t.problem)} aria-label=${o} disabled=${!y("manage")} onClick=${()=>s(t,t.enabled?"disable":"enable")}></button>
    </div>
    ${[t.problem,...t.hints].filter(Boolean).map(m=>e`<p key=${m} class="bad">${m}</p>`)}
    ${y("manage")&&p&&t.lacks.length>0&&e`<p class="choices"><button type="button" onClick=${()=>s(t,"edit",{act:t.lacks})}>${n("give it the right")}</button></p>`}
    <${S} of=${t}>${t.act.length>0&&e`<div><dt>${n("may command")}</dt><dd>${t.act.join(", ")}</dd></div>`}${b(t.next)>0&&e`<div><dt>${n("next")}</dt><dd>${w(l,t.next)}</dd></div>`}<//>
    ${a.length>0&&e`<details><summary>${n("last runs")}: ${x(a.at(-1).at)} ${a.at(-1).text}</summary>
      <ol class="log">${[...a].reverse().map((m,u)=>e`<li class="own" key=${u}><time>${x(m.at)}</time><span>${m.text}</span></li>`)}</ol>
    </details>`}
    ${y("manage")&&e`<p class="choices">
      <button type="button" onClick=${()=>s(t,"run")}>${n("run now")}</button>
      ${p&&e`<button type="button" onClick=${c}>${n("edit")}</button> <${q} name=${o} onRemove=${()=>s(t,"remove")} />`}
    </p>`}
  </section>`}function S({of:{when:t,conditions:l,steps:s},children:c}){let o=[["when",t],["if",l],["do",s]].filter(([,a])=>a.length);return e`<dl>
    ${o.map(([a,p])=>e`<div key=${a}><dt>${n(`${a}|routine`)}</dt><dd>${p.map((i,m)=>e`<div key=${m}>${i}</div>`)}</dd></div>`)}
    ${c}
  </dl>`}var B=t=>t.split(`
`).map(l=>l.trim()).filter(Boolean),T=(t,l)=>`${t} = [${B(l).map(s=>s.startsWith("{")?s:JSON.stringify(s)).join(", ")}]
`;function L({name:t,when:l,conditions:s,steps:c,mode:o}){let a=(B(s).length?T("if",s):"")+T("do",c)+(o===D[0]?"":`mode = "${o}"
`);return`[[routines]]
name = ${JSON.stringify(t.trim())}
${T("when",l)}${a}`}function Y({routine:t,change:l,onClose:s}){let c=!t.text,[o,a]=g(t.text??""),[p,i]=g(""),m=I(null),u=$=>a(L(Object.fromEntries(new FormData($.currentTarget)))),h=async $=>{$.preventDefault();let{success:d,message:f}=await l(t,c?"new":"edit",{text:o});if(d)return s();i(f),m.current.focus(),m.current.setSelectionRange(...Q(o,f))},r=($,d,f)=>e`<label>${d} <textarea name=${$} rows="2" placeholder=${f} required=${$!=="conditions"}></textarea></label>`;return e`<form class="card fields" onSubmit=${h}>
    ${c&&e`<div onInput=${$=>u({currentTarget:$.currentTarget.closest("form")})}>
      <label><span>${n("Name")}</span> <input name="name" required maxlength="100" /></label>
      ${r("when",n("when: what starts it, a line each"),`hall motion occupied
22:30 on weekdays`)}
      ${r("conditions",n("if: what must hold then, all of it"),"sun is down")}
      ${r("steps",n("do: its steps, a line each"),`hall lamp on, 20 %
wait 5m
undo`)}
      <label>${n("if it starts while it runs")} <select name="mode">${D.map($=>e`<option key=${$} value=${$}>${n(`${$}|mode`)}</option>`)}</select></label>
    </div>`}
    <label>${n("the text")} <textarea ref=${m} class="code" rows="7" spellcheck="false" required value=${o} onInput=${$=>a($.target.value)}></textarea></label>
    <p role="alert" class="bad">${p}</p>
    <p class="buttons"><button>${n("save")}</button> <button type="button" onClick=${s}>${n("not now")}</button></p>
  </form>`}function Q(t,l){let[,s,c=0]=l.match(/\.(when|if|do|mode|name)(?:\.(\d+))?: /)??[],o=s?t.search(new RegExp(`^\\s*${s}\\s*=`,"m")):-1,a=o<0?void 0:[...t.slice(o).matchAll(/"(?:[^"\\]|\\.)*"|'[^']*'|\{[^}]*\}/g)][c];if(a)return[o+a.index,o+a.index+a[0].length];let p=Number(l.match(/(?:\bline |^[^:]*:)(\d+)/)?.[1]??1/0),i=t.split(`
`).slice(0,p-1).join(`
`).length+(p>1?1:0);return[i,i+(t.split(`
`)[p-1]?.length??0)]}export{S as Parts,ht as Routines};
