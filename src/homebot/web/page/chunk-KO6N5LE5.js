import{l as xe}from"./chunk-24Q6OJX7.js";import{a as ve,b as ge,c as be,d as ye,e as ke}from"./chunk-WKP3TZRA.js";import{a as k,b as fe,c as he,d as G}from"./chunk-3WFHMPTW.js";import{a as f,h,j as ce,m as me,n as ue,q as pe,r as $e,s as de}from"./chunk-T7HJ6HO6.js";import{d as se,g as ae,k as F,l as ie,n as E,t as re,u as le}from"./chunk-E4ZU5TWP.js";import{a as g,b as R,k as ne}from"./chunk-YB32CKE5.js";import{d as te,g as _,h as z,r as K,t as oe}from"./chunk-Q45TKNX5.js";import{B as Y,C as j,E as ee,F as s,I as o,c as L,d as C,f as J,h as d,j as x,l as V,m as X,n as p,o as D,p as b,q as y,r as w,s as Z,t as O,v as M,w as T,x as A}from"./chunk-E5CCYWQY.js";var H=d([]),we=d(!1);A("/alerts/findings",t=>{H.value=t.findings,we.value=t.repeats});x(()=>{p.value.state==="connecting"&&(H.value=[])});var Q=()=>H.value.filter(t=>t.urgency!=="later");async function Fe(){let{success:t,message:e}=await T("/alerts/seen");ne(t?s("Nobody is told of it again."):e,t)}function Ye(){let t=H.value.filter(n=>n.urgency==="later"),e=Q();return o`
    ${e.map((n,a)=>o`<section key=${n.code} class="banner alarm" role="alert"><${h} path=${f.alert} size=${48} />
        <div>
          <h2>${s(n.title||"problem")}</h2>
          ${n.rows.map(i=>o`<p key=${i.what+i.why}>${E(i.what)&&o`<button type="button" class="link" onClick=${()=>he(i.what)}>${le(i.what)}</button>`} ${(j.value==="en"||!i.what)&&i.why}</p>`)}
          ${n.next&&o`<p><strong>${s(n.next)}</strong></p>`}
        </div>
        ${a===e.length-1&&we.value&&y("act")&&o`<button type="button" class="seen" onClick=${Fe}><${h} path=${f.check} /> ${s("I have seen it")}</button>`}
      </section>`)}
    ${t.length>0&&o`<p class="notes"><a href="#/system">${t.map(n=>`${s(n.title)}: ${n.total}`).join(" \xB7 ")}</a></p>`}`}var U=d([]),P=d("");A("/control/questions",t=>{U.value=t.questions,P.value=""});x(()=>{p.value.state==="connecting"&&(U.value=[])});async function Ge({question:t},e){let{success:n,message:a}=await T("/control/answer",{question:t,yes:e});P.value=a,!n&&!w.value&&(b.value=a)}var Se=({text:t,problem:e,onAnswer:n})=>o`<section class="question" role="alert" aria-label=${s("question")}>
  <p><strong>${t}?</strong></p>
  ${y("act")&&o`<p class="buttons"><${ce} text=${s("do it")} onHeld=${()=>n(!0)} /> <button type="button" onClick=${()=>n(!1)}>${s("no")}</button></p>`}
  ${e&&o`<p class="bad">${e}</p>`}
</section>`;function Le(){let{text:t,act:e}=R.value??{},n=a=>{R.value=null,a&&e()};return R.value&&o`<div class="agreement"><${Se} text=${t} onAnswer=${n} /></div>`}var Ce=()=>U.value.map(t=>o`<${Se} key=${t.question} text=${t.text} problem=${P.value} onAnswer=${e=>Ge(t,e)} />`);var Ee=24,[N,I]=[480,64],He=["power","local_temperature","temperature","humidity","on_off","contact","occupancy","level","position","illuminance","battery"];function Ie({device:t,capability:e}){let n=e??He.find(u=>[...t.states.values()].some(({capability:v,value:B})=>v===u&&B!==null)),[a,i]=L(null),c=p.value.state==="open";C(()=>{if(!n||!c)return;let u=V(),v=u-Ee*3600;M("/history/read",{device:t.id,capability:n,points:120,since:{sec:Math.floor(v),nanosec:0}}).then(B=>i({since:v,to:u,series:B.series.find(Re=>Re.times.length)}),()=>{})},[t.id,n,c]);let{series:r,since:l,to:m}=a??{};if(!r)return null;let $=u=>Math.max(0,N*(u-l)/(m-l)),Ae=`${z(n)}, ${K.value.format(l*1e3)} \u2013 ${s("now")}`,je=[0,1,2,3,4].map(u=>K.value.format((l+u*Ee*3600/4)*1e3));return o`<section class="mini"><h3>${s("the last 24 hours")} <small>${z(n)}</small></h3>
    <svg viewBox=${`0 0 ${N} ${I}`} preserveAspectRatio="none" role="img" aria-label=${Ae}>${r.values.length?o`<${Ne} series=${r} x=${$} to=${m} />`:o`<rect class="base" y="20" width=${N} height="24" />${r.words.map((u,v)=>u==="true"&&o`<rect key=${v} class="on" y="20" height="24" x=${$(r.times[v])} width=${Math.max(2,$(r.ends[v])-$(r.times[v]))} />`)}`}</svg>
    ${r.values.length>0&&o`<p class="span"><span>${_(n,Math.min(...r.values))}</span><span>${_(n,Math.max(...r.values))}</span></p>`}
    <p class="axis" aria-hidden="true">${je.map(u=>o`<span key=${u}>${u}</span>`)}</p></section>`}function Ne({series:{times:t,values:e},x:n,to:a}){let[i,c]=[Math.min(...e),Math.max(...e)],r=m=>c===i?I/2:4+(I-8)*(c-m)/(c-i),l=[...t.map((m,$)=>[n(m),r(e[$])]),[n(a),r(e.at(-1))]].map(m=>m.map($=>$.toFixed(1)).join(","));return o`<path class="under" d=${`M${l[0].split(",")[0]},${I} L${l.join(" L")} L${N},${I}Z`} /><path class="line" d=${`M${l.join(" L")}`} />`}var qe=350;function Oe(){return k.value&&E(k.value)?o`<${Be} key=${k.value} id=${k.value} />`:null}function Be({id:t}){let e=E(t).value,n=J(null),[a,i]=L(!1);C(()=>{n.current.focus();let l=setTimeout(()=>i(!0),qe),m=$=>$.key==="Escape"&&G();return addEventListener("keydown",m),document.documentElement.classList.add("covered"),()=>{clearTimeout(l),removeEventListener("keydown",m),document.documentElement.classList.remove("covered"),setTimeout(fe)}},[]);let c=ue(e),r=se("favorites",t);return o`<div class="shade" onClick=${()=>a&&G()}></div>
    <section ref=${n} class=${a?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${pe(e)}`}><${h} path=${$e(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&te(e.room),de(e)].filter(Boolean).join(" \xB7 ")} <${be} device=${e} /></p></div>
        ${y("act")&&o`<button type="button" class="round" aria-pressed=${String(r)} aria-label=${s("favorite")} onClick=${()=>ae("favorites",t,!r)}><${h} path=${r?f.star:f.starOff} /></button>`}
        <button type="button" class="round" aria-label=${s("close|do")} onClick=${G}><${h} path=${f.close} /></button></header>
      <div class="body">
        <${ge} device=${e} />
        ${e.may_act&&(c.Main?o`<${c.Main} device=${e} />`:c.act?.(e)&&o`<div class="solo"><${me} device=${e} act=${c.act(e)} /></div>`)}
        <${ke} device=${e} isShort />
        <${De} device=${e} main=${c.main} />
        ${y("manage")&&o`<details class="part"><summary>${s("Name, room and tags")}</summary><${ye} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${s("Values, history, facts")} <${h} path=${f.right} /></a></p>
        <${Ie} device=${e} />
      </div>
    </section>`}function De({device:t,main:e}){let[n,a]=L(null),i=p.value.state==="open",c=t.settable.filter(r=>!e.includes(r));return C(()=>{i&&c.length&&M("/discovery/find_devices",{ids:[t.id]}).then(r=>a(r.devices[0]),()=>{})},[t.id,i]),!c.length||!t.may_act?null:o`<details class="part" open=${e.length===0}><summary>${s("More controls")}</summary>${n&&o`<${ve} short=${t} device=${n} without=${e} />`}</details>`}var S=d(!1),_e={home:"Home",security:"Security",climate:"Climate",energy:"Energy"},Me={plan:"Plan",routines:"Routines",journal:"Journal",system:"System"},W=({view:t,text:e,above:n,mark:a,name:i=""})=>o`<a href=${`#/${t}`} class=${i} aria-current=${t===n?"page":void 0}><${h} path=${f[t]} size=${26} /><span>${s(e)}</span>${a>0&&o`<b>${a}</b>`}</a>`;function Qt({above:t,children:e}){let{state:n,reason:a}=p.value,i=n==="refused",c={home:Q().length,security:xe(re.value).length},r=l=>{l.preventDefault(),document.getElementById("content").focus()};return o`<div class="frame" inert=${!!k.value}>
      <a class="skip" href="#content" onClick=${r}>${s("to the content")}</a>
      <nav class="rail" aria-label=${s("views")}>
        ${Object.entries(_e).map(([l,m])=>o`<${W} key=${l} view=${l} text=${m} above=${t} mark=${c[l]} />`)}
        ${Object.entries(Me).map(([l,m])=>o`<${W} key=${l} view=${l} text=${m} above=${t} name="last" />`)}
        <${W} view="more" text="More" above=${t in Me?"more":t} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${n==="open"?"hidden":"notice"}>${n==="open"?s(F.value===1?"{count} device":"{count} devices",{count:F.value}):i?s("not logged in"):a&&D.value?s("homebot cannot be reached since {time}: perhaps it is restarting.",{time:oe({sec:D.value,nanosec:0})}):s(a||"connecting \u2026")}</p>
        ${(i||S.value||b.value)&&o`<${ze} reason=${i?a:b.value} />`}
        ${ie.value&&!F.value&&t!=="system"&&o`<p class="notice"><a href="#/setup">${s("No device is there yet: set up your home.")}</a></p>`}
        <${Ce} />
        <main id="content" tabindex="-1" class=${n==="open"?"":"old"}>${e}</main>
      </div>
    </div>
    <${Oe} />
    <div class="told"><${Le} />
      <p role="alert" class=${g.value?`outcome ${g.value.isGood?"good":"bad"}`:"hidden"}>
        ${g.value?.text} ${g.value?.override&&o`<button type="button" onClick=${g.value.override}>${s("Command it all the same?")}</button>`} ${g.value&&!g.value.isGood&&o`<button type="button" onClick=${()=>g.value=null}>${s("close|do")}</button>`}
      </p></div>`}function ze({reason:t}){let e=n=>{n.preventDefault();let a=new FormData(n.target);S.value=!1,Z(a.get("token").trim(),a.get("remember")==="on")};return o`<form class="card fields" aria-label=${s("log in")} onSubmit=${e}>
    ${t&&o`<p class="bad">${s(t)}</p>`}
    <p>${s("The code that homebot run prints lets a first screen in.")}</p>
    <p>${s("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${s("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${s("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${s("log in")}</button> ${t&&(w.value||t===X)&&o`<button type="button" onClick=${O}>${s("go on without a token")}</button>`} ${b.value&&o`<button type="button" onClick=${()=>b.value=""}>${s("not now")}</button>`}</p>
  </form>`}var Te="homebot.theme",Ke={"":"as the system",light:"light|theme",dark:"dark|theme"},q=d(localStorage.getItem(Te)??"");x(()=>{localStorage.setItem(Te,q.value),document.documentElement.dataset.theme=q.value});function Zt(){let t=w.value&&p.value.state!=="refused";return o`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${s("This screen")}</h2>
    <label><span>${s("Language")}</span> <select name="language" onChange=${e=>ee(e.target.value)}>${Object.entries(Y).map(([e,n])=>o`<option key=${e} value=${e} lang=${e} selected=${e===j.value}>${n}</option>`)}</select></label>
    <label><span>${s("Colors")}</span> <select name="theme" onChange=${e=>q.value=e.target.value}>${Object.entries(Ke).map(([e,n])=>o`<option key=${e} value=${e} selected=${e===q.value}>${s(n)}</option>`)}</select></label>
    <p class="choices">${t?o`<button type="button" onClick=${O}>${s("log out")}</button>`:o`<button type="button" aria-expanded=${S.value} onClick=${()=>S.value=!S.value}>${s("log in")}</button>`}</p>
  </section>`}export{Ye as a,Ie as b,Me as c,Qt as d,Zt as e};
