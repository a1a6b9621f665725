import{Fa as A,Ga as E,L as S,P as k,Q as T,T as N,V as O,Va as M,W as e,X as j,a as f,b as v,d as x,j as R,k as g,m as C,n as y,v as a,z as I}from"./chunk-ISDX2PJM.js";var _=j(async()=>(await import("./gallery-QQINN5KD.js")).Gallery),D=5e3,q=["single","restart","queued","parallel"];function Z(){let[t,l]=f(null),[n,r]=f(null),i=R.value.state==="open",s=()=>C("/routines/list",{check:!0}).then(l,o=>l({routines:[],problem:o.message}));v(()=>{if(!i)return;s();let o=setInterval(s,D);return()=>clearInterval(o)},[i]);let m=async(o,$,b)=>{let h={name:o.name,change:$,...b},d=await y("/routines/change",{...h,unless_asks:!0});if(d.asks?.length){let c=d.asks.map(({key:u,value:p})=>I(u)+(p&&` (${p})`)).join(", ");await new Promise(u=>N($==="run"?`${o.name}: ${c}`:a("let this routine command {names}",{names:c}),u)),d=await y("/routines/change",h)}return(d.success||!b?.text)&&O(d.message,d.success),s(),d};return t?e`
    ${t.problem&&e`<p class="bad">${t.problem}</p>`}
    ${!t.routines.length&&e`<p class="empty">${a("There is no routine yet.")}</p>`}
    <${A}>${!n&&e`<p class="choices"><button type="button" onClick=${()=>r({})}>${a("new routine")}</button> <button type="button" onClick=${()=>r({isReadyMade:!0})}>${a("ready-made routines")}</button></p>`}<//>
    ${n?.isReadyMade&&e`<${_} onText=${o=>r({draft:o})} onClose=${()=>r(null)} />`}
    ${n&&!n.isReadyMade&&e`<${B} key=${n.name??""} routine=${n} change=${m} onClose=${()=>r(null)} />`}
    <div class="columns">${t.routines.map(o=>e`<${F} key=${o.app} routine=${o} zone=${t.zone} change=${m} onEdit=${()=>r(o)} />`)}</div>
    <${M} at="routines" zone=${t.zone} onChange=${s} Parts=${z} />`:e`<p class="empty">${a("Asking homebot for its routines \u2026")}</p>`}function F({routine:t,zone:l,change:n,onEdit:r}){let{name:i,notes:s,is_kept:m,proposed_by:o}=t;return e`<section>
    <div class="title">
      <h2><bdi>${i}</bdi></h2>
      ${t.is_running&&e`<span class="mark">${a("running")}</span>`}
      ${o&&e`<span class="mark">${a("proposed by {name}",{name:o})}</span>`}
      <button type="button" class="switch" role="switch" aria-checked=${String(t.enabled&&!t.problem)} aria-label=${i} disabled=${!g("manage")} onClick=${()=>n(t,t.enabled?"disable":"enable")}></button>
    </div>
    ${[t.problem,...t.hints].filter(Boolean).map($=>e`<p key=${$} class="bad">${$}</p>`)}
    ${g("manage")&&m&&t.lacks.length>0&&e`<p class="choices"><button type="button" onClick=${()=>n(t,"edit",{act:t.lacks})}>${a("give it the right")}</button></p>`}
    <${z} of=${t}>${t.act.length>0&&e`<div><dt>${a("may command")}</dt><dd>${t.act.join(", ")}</dd></div>`}${S(t.next)>0&&e`<div><dt>${a("next")}</dt><dd>${T(l,t.next)}</dd></div>`}<//>
    ${s.length>0&&e`<details><summary>${a("last runs")}: ${k(s.at(-1).at)} ${s.at(-1).text}</summary>
      <ol class="log">${[...s].reverse().map(($,b)=>e`<li class="own" key=${b}><time>${k($.at)}</time><span>${$.text}</span></li>`)}</ol>
    </details>`}
    ${g("manage")&&e`<p class="choices">
      <button type="button" onClick=${()=>n(t,"run")}>${a("run now")}</button>
      ${m&&e`<button type="button" onClick=${r}>${a("edit")}</button> <${E} name=${i} onRemove=${()=>n(t,"remove")} />`}
    </p>`}
  </section>`}function z({of:{when:t,conditions:l,steps:n},children:r}){let i=[["when",t],["if",l],["do",n]].filter(([,s])=>s.length);return e`<dl>
    ${i.map(([s,m])=>e`<div key=${s}><dt>${a(`${s}|routine`)}</dt><dd>${m.map((o,$)=>e`<div key=${$}>${o}</div>`)}</dd></div>`)}
    ${r}
  </dl>`}var P=t=>t.split(`
`).map(l=>l.trim()).filter(Boolean),w=(t,l)=>`${t} = [${P(l).map(n=>n.startsWith("{")?n:JSON.stringify(n)).join(", ")}]
`;function G({name:t,when:l,conditions:n,steps:r,mode:i}){let s=(P(n).length?w("if",n):"")+w("do",r)+(i===q[0]?"":`mode = "${i}"
`);return`[[routines]]
name = ${JSON.stringify(t.trim())}
${w("when",l)}${s}`}function B({routine:t,change:l,onClose:n}){let r=!t.text,[i,s]=f(t.text??t.draft??""),[m,o]=f(""),$=x(null),b=c=>s(G(Object.fromEntries(new FormData(c.currentTarget)))),h=async c=>{c.preventDefault();let{success:u,message:p}=await l(t,r?"new":"edit",{text:i});if(u)return n();o(p),$.current.focus(),$.current.setSelectionRange(...J(i,p))},d=(c,u,p)=>e`<label>${u} <textarea name=${c} rows="2" placeholder=${p} required=${c!=="conditions"}></textarea></label>`;return e`<form class="card fields" onSubmit=${h}>
    ${r&&!t.draft&&e`<div onInput=${c=>b({currentTarget:c.currentTarget.closest("form")})}>
      <label><span>${a("Name")}</span> <input name="name" required maxlength="100" /></label>
      ${d("when",a("when: what starts it, a line each"),`hall motion occupied
22:30 on weekdays`)}
      ${d("conditions",a("if: what must hold then, all of it"),"sun is down")}
      ${d("steps",a("do: its steps, a line each"),`hall lamp on, 20 %
wait 5m
undo`)}
      <label>${a("if it starts while it runs")} <select name="mode">${q.map(c=>e`<option key=${c} value=${c}>${a(`${c}|mode`)}</option>`)}</select></label>
    </div>`}
    <label>${a("the text")} <textarea ref=${$} class="code" rows="7" spellcheck="false" required value=${i} onInput=${c=>s(c.target.value)}></textarea></label>
    <p role="alert" class="bad">${m}</p>
    <p class="buttons"><button>${a("save")}</button> <button type="button" onClick=${n}>${a("not now")}</button></p>
  </form>`}function J(t,l){let[,n,r=0]=l.match(/\.(when|if|do|mode|name)(?:\.(\d+))?: /)??[],i=n?t.search(new RegExp(`^\\s*${n}\\s*=`,"m")):-1,s=i<0?void 0:[...t.slice(i).matchAll(/"(?:[^"\\]|\\.)*"|'[^']*'|\{[^}]*\}/g)][r];if(s)return[i+s.index,i+s.index+s[0].length];let m=Number(l.match(/(?:\bline |^[^:]*:)(\d+)/)?.[1]??1/0),o=t.split(`
`).slice(0,m-1).join(`
`).length+(m>1?1:0);return[o,o+(t.split(`
`)[m-1]?.length??0)]}export{Z as Routines};
