import{L as S,P as y,Pa as j,Q as N,Qa as A,Ra as E,T as O,V as T,a as f,b as v,d as x,ia as t,j as I,k as g,m as C,n as k,v as a,z as R}from"./chunk-XMAA5WJE.js";var _=5e3,q=["single","restart","queued","parallel"];function V(){let[e,l]=f(null),[n,c]=f(null),o=I.value.state==="open",s=()=>C("/routines/list",{check:!0}).then(l,i=>l({routines:[],problem:i.message}));v(()=>{if(!o)return;s();let i=setInterval(s,_);return()=>clearInterval(i)},[o]);let m=async(i,$,b)=>{let h={name:i.name,change:$,...b},d=await k("/routines/change",{...h,unless_asks:!0});if(d.asks?.length){let r=d.asks.map(({key:p,value:u})=>R(p)+(u&&` (${u})`)).join(", ");await new Promise(p=>O($==="run"?`${i.name}: ${r}`:a("let this routine command {names}",{names:r}),p)),d=await k("/routines/change",h)}return(d.success||!b?.text)&&T(d.message,d.success),s(),d};return e?t`
    ${e.problem&&t`<p class="bad">${e.problem}</p>`}
    ${!e.routines.length&&t`<p class="empty">${a("There is no routine yet.")}</p>`}
    <${j}>${!n&&t`<p class="choices"><button type="button" onClick=${()=>c({})}>${a("new routine")}</button></p>`}<//>
    ${n&&t`<${B} key=${n.name??""} routine=${n} change=${m} onClose=${()=>c(null)} />`}
    <div class="columns">${e.routines.map(i=>t`<${D} key=${i.app} routine=${i} zone=${e.zone} change=${m} onEdit=${()=>c(i)} />`)}</div>
    <${E} at="routines" zone=${e.zone} onChange=${s} Parts=${z} />`:t`<p class="empty">${a("Asking homebot for its routines \u2026")}</p>`}function D({routine:e,zone:l,change:n,onEdit:c}){let{name:o,notes:s,is_kept:m,proposed_by:i}=e;return t`<section>
    <div class="title">
      <h2><bdi>${o}</bdi></h2>
      ${e.is_running&&t`<span class="mark">${a("running")}</span>`}
      ${i&&t`<span class="mark">${a("proposed by {name}",{name:i})}</span>`}
      <button type="button" class="switch" role="switch" aria-checked=${String(e.enabled&&!e.problem)} aria-label=${o} disabled=${!g("manage")} onClick=${()=>n(e,e.enabled?"disable":"enable")}></button>
    </div>
    ${[e.problem,...e.hints].filter(Boolean).map($=>t`<p key=${$} class="bad">${$}</p>`)}
    ${g("manage")&&m&&e.lacks.length>0&&t`<p class="choices"><button type="button" onClick=${()=>n(e,"edit",{act:e.lacks})}>${a("give it the right")}</button></p>`}
    <${z} of=${e}>${e.act.length>0&&t`<div><dt>${a("may command")}</dt><dd>${e.act.join(", ")}</dd></div>`}${S(e.next)>0&&t`<div><dt>${a("next")}</dt><dd>${N(l,e.next)}</dd></div>`}<//>
    ${s.length>0&&t`<details><summary>${a("last runs")}: ${y(s.at(-1).at)} ${s.at(-1).text}</summary>
      <ol class="log">${[...s].reverse().map(($,b)=>t`<li class="own" key=${b}><time>${y($.at)}</time><span>${$.text}</span></li>`)}</ol>
    </details>`}
    ${g("manage")&&t`<p class="choices">
      <button type="button" onClick=${()=>n(e,"run")}>${a("run now")}</button>
      ${m&&t`<button type="button" onClick=${c}>${a("edit")}</button> <${A} name=${o} onRemove=${()=>n(e,"remove")} />`}
    </p>`}
  </section>`}function z({of:{when:e,conditions:l,steps:n},children:c}){let o=[["when",e],["if",l],["do",n]].filter(([,s])=>s.length);return t`<dl>
    ${o.map(([s,m])=>t`<div key=${s}><dt>${a(`${s}|routine`)}</dt><dd>${m.map((i,$)=>t`<div key=${$}>${i}</div>`)}</dd></div>`)}
    ${c}
  </dl>`}var P=e=>e.split(`
`).map(l=>l.trim()).filter(Boolean),w=(e,l)=>`${e} = [${P(l).map(n=>n.startsWith("{")?n:JSON.stringify(n)).join(", ")}]
`;function F({name:e,when:l,conditions:n,steps:c,mode:o}){let s=(P(n).length?w("if",n):"")+w("do",c)+(o===q[0]?"":`mode = "${o}"
`);return`[[routines]]
name = ${JSON.stringify(e.trim())}
${w("when",l)}${s}`}function B({routine:e,change:l,onClose:n}){let c=!e.text,[o,s]=f(e.text??""),[m,i]=f(""),$=x(null),b=r=>s(F(Object.fromEntries(new FormData(r.currentTarget)))),h=async r=>{r.preventDefault();let{success:p,message:u}=await l(e,c?"new":"edit",{text:o});if(p)return n();i(u),$.current.focus(),$.current.setSelectionRange(...J(o,u))},d=(r,p,u)=>t`<label>${p} <textarea name=${r} rows="2" placeholder=${u} required=${r!=="conditions"}></textarea></label>`;return t`<form class="card fields" onSubmit=${h}>
    ${c&&t`<div onInput=${r=>b({currentTarget:r.currentTarget.closest("form")})}>
      <label><span>${a("Name")}</span> <input name="name" required maxlength="100" /></label>
      ${d("when",a("when: what starts it, a line each"),`hall motion occupied
22:30 on weekdays`)}
      ${d("conditions",a("if: what must hold then, all of it"),"sun is down")}
      ${d("steps",a("do: its steps, a line each"),`hall lamp on, 20 %
wait 5m
undo`)}
      <label>${a("if it starts while it runs")} <select name="mode">${q.map(r=>t`<option key=${r} value=${r}>${a(`${r}|mode`)}</option>`)}</select></label>
    </div>`}
    <label>${a("the text")} <textarea ref=${$} class="code" rows="7" spellcheck="false" required value=${o} onInput=${r=>s(r.target.value)}></textarea></label>
    <p role="alert" class="bad">${m}</p>
    <p class="buttons"><button>${a("save")}</button> <button type="button" onClick=${n}>${a("not now")}</button></p>
  </form>`}function J(e,l){let[,n,c=0]=l.match(/\.(when|if|do|mode|name)(?:\.(\d+))?: /)??[],o=n?e.search(new RegExp(`^\\s*${n}\\s*=`,"m")):-1,s=o<0?void 0:[...e.slice(o).matchAll(/"(?:[^"\\]|\\.)*"|'[^']*'|\{[^}]*\}/g)][c];if(s)return[o+s.index,o+s.index+s[0].length];let m=Number(l.match(/(?:\bline |^[^:]*:)(\d+)/)?.[1]??1/0),i=e.split(`
`).slice(0,m-1).join(`
`).length+(m>1?1:0);return[i,i+(e.split(`
`)[m-1]?.length??0)]}export{V as Routines};
