import"./chunk-HJ5TEVRD.js";import{$ as j,A as a,B as y,E as S,Ha as A,Ia as E,Q as T,U as w,V as N,Z as O,a as f,aa as t,b as x,d as R,hb as M,jb as q,k as C,m as g,r as I,s as k}from"./chunk-VQMOVCEH.js";var D=M(async()=>(await import("./gallery-G4U33LM2.js")).Gallery),F=5e3,z=["single","restart","queued","parallel"];function ee(){let[e,l]=f(null),[n,r]=f(null),i=C.value.state==="open",s=()=>I("/routines/list",{check:!0}).then(l,o=>l({routines:[],problem:o.message}));x(()=>{if(!i)return;s();let o=setInterval(s,F);return()=>clearInterval(o)},[i]);let m=async(o,$,b)=>{let h={name:o.name,change:$,...b},d=await k("/routines/change",{...h,unless_asks:!0});if(d.asks?.length){let c=d.asks.map(({key:u,value:p})=>S(u)+(p&&` (${p})`)).join(", ");await new Promise(u=>O($==="run"?`${o.name}: ${c}`:a("let this routine command {names}",{names:c}),u)),d=await k("/routines/change",h)}return(d.success||!b?.text)&&j(d.message,d.success),s(),d};return e?t`
    ${e.problem&&t`<p class="bad">${e.problem}</p>`}
    ${!e.routines.length&&t`<p class="empty">${a("There is no routine yet.")}</p>`}
    <${A}>${!n&&t`<p class="choices"><button type="button" onClick=${()=>r({})}>${a("new routine")}</button> <button type="button" onClick=${()=>r({isReadyMade:!0})}>${a("ready-made routines")}</button></p>`}<//>
    ${n?.isReadyMade&&t`<${D} onText=${o=>r({draft:o})} onClose=${()=>r(null)} />`}
    ${n&&!n.isReadyMade&&t`<${J} key=${n.name??""} routine=${n} change=${m} onClose=${()=>r(null)} />`}
    <div class="columns">${e.routines.map(o=>t`<${G} key=${o.app} routine=${o} zone=${e.zone} change=${m} onEdit=${()=>r(o)} />`)}</div>
    <${q} at="routines" zone=${e.zone} onChange=${s} Parts=${P} />`:t`<p class="empty">${a("Asking homebot for its routines \u2026")}</p>`}function G({routine:e,zone:l,change:n,onEdit:r}){let{name:i,notes:s,is_kept:m,proposed_by:o}=e;return t`<section>
    <div class="title">
      <h2><bdi>${i}</bdi></h2>
      ${e.is_running&&t`<span class="mark">${a("running")}</span>`}
      ${o&&t`<span class="mark">${a("proposed by {name}",{name:o})}</span>`}
      <button type="button" class="switch" role="switch" aria-checked=${String(e.enabled&&!e.problem)} aria-label=${i} disabled=${!g("manage")} onClick=${()=>n(e,e.enabled?"disable":"enable")}></button>
    </div>
    ${[e.problem,...e.hints].filter(Boolean).map($=>t`<p key=${$} class="bad">${y($)}</p>`)}
    ${g("manage")&&m&&e.lacks.length>0&&t`<p class="choices"><button type="button" onClick=${()=>n(e,"edit",{act:e.lacks})}>${a("give it the right")}</button></p>`}
    <${P} of=${e}>${e.act.length>0&&t`<div><dt>${a("may command")}</dt><dd>${e.act.join(", ")}</dd></div>`}${T(e.next)>0&&t`<div><dt>${a("next")}</dt><dd>${N(l,e.next)}</dd></div>`}<//>
    ${s.length>0&&t`<details><summary>${a("last runs")}: ${w(s.at(-1).at)} ${y(s.at(-1).text)}</summary>
      <ol class="log">${[...s].reverse().map(($,b)=>t`<li class="own" key=${b}><time>${w($.at)}</time><span>${y($.text)}</span></li>`)}</ol>
    </details>`}
    ${g("manage")&&t`<p class="choices">
      <button type="button" onClick=${()=>n(e,"run")}>${a("run now")}</button>
      ${m&&t`<button type="button" onClick=${r}>${a("edit")}</button> <${E} name=${i} onRemove=${()=>n(e,"remove")} />`}
    </p>`}
  </section>`}function P({of:{when:e,conditions:l,steps:n},children:r}){let i=[["when",e],["if",l],["do",n]].filter(([,s])=>s.length);return t`<dl>
    ${i.map(([s,m])=>t`<div key=${s}><dt>${a(`${s}|routine`)}</dt><dd>${m.map((o,$)=>t`<div key=${$}>${o}</div>`)}</dd></div>`)}
    ${r}
  </dl>`}var _=e=>e.split(`
`).map(l=>l.trim()).filter(Boolean),v=(e,l)=>`${e} = [${_(l).map(n=>n.startsWith("{")?n:JSON.stringify(n)).join(", ")}]
`;function B({name:e,when:l,conditions:n,steps:r,mode:i}){let s=(_(n).length?v("if",n):"")+v("do",r)+(i===z[0]?"":`mode = "${i}"
`);return`[[routines]]
name = ${JSON.stringify(e.trim())}
${v("when",l)}${s}`}function J({routine:e,change:l,onClose:n}){let r=!e.text,[i,s]=f(e.text??e.draft??""),[m,o]=f(""),$=R(null),b=c=>s(B(Object.fromEntries(new FormData(c.currentTarget)))),h=async c=>{c.preventDefault();let{success:u,message:p}=await l(e,r?"new":"edit",{text:i});if(u)return n();o(p),$.current.focus(),$.current.setSelectionRange(...W(i,p))},d=(c,u,p)=>t`<label>${u} <textarea name=${c} rows="2" placeholder=${p} required=${c!=="conditions"}></textarea></label>`;return t`<form class="card fields" onSubmit=${h}>
    ${r&&!e.draft&&t`<div onInput=${c=>b({currentTarget:c.currentTarget.closest("form")})}>
      <label><span>${a("Name")}</span> <input name="name" required maxlength="100" /></label>
      ${d("when",a("when: what starts it, a line each"),`hall motion occupied
22:30 on weekdays`)}
      ${d("conditions",a("if: what must hold then, all of it"),"sun is down")}
      ${d("steps",a("do: its steps, a line each"),`hall lamp on, 20 %
wait 5m
undo`)}
      <label>${a("if it starts while it runs")} <select name="mode">${z.map(c=>t`<option key=${c} value=${c}>${a(`${c}|mode`)}</option>`)}</select></label>
    </div>`}
    <label>${a("the text")} <textarea ref=${$} class="code" rows="7" spellcheck="false" required value=${i} onInput=${c=>s(c.target.value)}></textarea></label>
    <p role="alert" class="bad">${m}</p>
    <p class="buttons"><button>${a("save")}</button> <button type="button" onClick=${n}>${a("not now")}</button></p>
  </form>`}function W(e,l){let[,n,r=0]=l.match(/\.(when|if|do|mode|name)(?:\.(\d+))?: /)??[],i=n?e.search(new RegExp(`^\\s*${n}\\s*=`,"m")):-1,s=i<0?void 0:[...e.slice(i).matchAll(/"(?:[^"\\]|\\.)*"|'[^']*'|\{[^}]*\}/g)][r];if(s)return[i+s.index,i+s.index+s[0].length];let m=Number(l.match(/(?:\bline |^[^:]*:)(\d+)/)?.[1]??1/0),o=e.split(`
`).slice(0,m-1).join(`
`).length+(m>1?1:0);return[o,o+(e.split(`
`)[m-1]?.length??0)]}export{ee as Routines};
