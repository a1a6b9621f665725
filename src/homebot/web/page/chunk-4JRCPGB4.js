import{l as ye}from"./chunk-D5EUVS76.js";import{a as fe,b as he,c as ve,d as ge,e as be}from"./chunk-V3ZFFJN5.js";import{a as k,b as pe,c as de,d as G}from"./chunk-7EY7HHSY.js";import{a as f,h,j as re,m as le,n as ce,q as me,r as ue,s as $e}from"./chunk-XBU2O3QS.js";import{d as oe,f as ne,j as F,k as se,m as E,s as ae,t as ie}from"./chunk-5P2UGUKK.js";import{a as g,b as R,k as te}from"./chunk-ZEPDM3RH.js";import{d as ee,g as D,h as _,r as z}from"./chunk-AUYVAPFZ.js";import{A as Z,B as j,D as Y,E as s,H as o,c as L,d as C,f as W,h as d,j as x,l as J,m as V,n as $,o as b,p as y,q as w,r as X,s as O,u as M,v as T,w as A}from"./chunk-FJW2QC2U.js";var H=d([]),ke=d(!1);A("/alerts/findings",t=>{H.value=t.findings,ke.value=t.repeats});x(()=>{$.value.state==="connecting"&&(H.value=[])});var K=()=>H.value.filter(t=>t.urgency!=="later");async function je(){let{success:t,message:e}=await T("/alerts/seen");te(t?s("Nobody is told of it again."):e,t)}function Xe(){let t=H.value.filter(n=>n.urgency==="later"),e=K();return o`
    ${e.map((n,a)=>o`<section key=${n.code} class="banner alarm" role="alert"><${h} path=${f.alert} size=${48} />
        <div>
          <h2>${s(n.title||"problem")}</h2>
          ${n.rows.map(i=>o`<p key=${i.what+i.why}>${E(i.what)&&o`<button type="button" class="link" onClick=${()=>de(i.what)}>${ie(i.what)}</button>`} ${(j.value==="en"||!i.what)&&i.why}</p>`)}
          ${n.next&&o`<p><strong>${s(n.next)}</strong></p>`}
        </div>
        ${a===e.length-1&&ke.value&&y("act")&&o`<button type="button" class="seen" onClick=${je}><${h} path=${f.check} /> ${s("I have seen it")}</button>`}
      </section>`)}
    ${t.length>0&&o`<p class="notes"><a href="#/system">${t.map(n=>`${s(n.title)}: ${n.total}`).join(" \xB7 ")}</a></p>`}`}var Q=d([]),U=d("");A("/control/questions",t=>{Q.value=t.questions,U.value=""});x(()=>{$.value.state==="connecting"&&(Q.value=[])});async function Re({question:t},e){let{success:n,message:a}=await T("/control/answer",{question:t,yes:e});U.value=a,!n&&!w.value&&(b.value=a)}var xe=({text:t,problem:e,onAnswer:n})=>o`<section class="question" role="alert" aria-label=${s("question")}>
  <p><strong>${t}?</strong></p>
  ${y("act")&&o`<p class="buttons"><${re} text=${s("do it")} onHeld=${()=>n(!0)} /> <button type="button" onClick=${()=>n(!1)}>${s("no")}</button></p>`}
  ${e&&o`<p class="bad">${e}</p>`}
</section>`;function we(){let{text:t,act:e}=R.value??{},n=a=>{R.value=null,a&&e()};return R.value&&o`<div class="agreement"><${xe} text=${t} onAnswer=${n} /></div>`}var Se=()=>Q.value.map(t=>o`<${xe} key=${t.question} text=${t.text} problem=${U.value} onAnswer=${e=>Re(t,e)} />`);var Le=24,[N,I]=[480,64],Fe=["power","local_temperature","temperature","humidity","on_off","contact","occupancy","level","position","illuminance","battery"];function Ce({device:t,capability:e}){let n=e??Fe.find(u=>[...t.states.values()].some(({capability:v,value:B})=>v===u&&B!==null)),[a,i]=L(null),c=$.value.state==="open";C(()=>{if(!n||!c)return;let u=J(),v=u-Le*3600;M("/history/read",{device:t.id,capability:n,points:120,since:{sec:Math.floor(v),nanosec:0}}).then(B=>i({since:v,to:u,series:B.series.find(Ae=>Ae.times.length)}),()=>{})},[t.id,n,c]);let{series:r,since:l,to:m}=a??{};if(!r)return null;let p=u=>Math.max(0,N*(u-l)/(m-l)),Me=`${_(n)}, ${z.value.format(l*1e3)} \u2013 ${s("now")}`,Te=[0,1,2,3,4].map(u=>z.value.format((l+u*Le*3600/4)*1e3));return o`<section class="mini"><h3>${s("the last 24 hours")} <small>${_(n)}</small></h3>
    <svg viewBox=${`0 0 ${N} ${I}`} preserveAspectRatio="none" role="img" aria-label=${Me}>${r.values.length?o`<${Ge} series=${r} x=${p} to=${m} />`:o`<rect class="base" y="20" width=${N} height="24" />${r.words.map((u,v)=>u==="true"&&o`<rect key=${v} class="on" y="20" height="24" x=${p(r.times[v])} width=${Math.max(2,p(r.ends[v])-p(r.times[v]))} />`)}`}</svg>
    ${r.values.length>0&&o`<p class="span"><span>${D(n,Math.min(...r.values))}</span><span>${D(n,Math.max(...r.values))}</span></p>`}
    <p class="axis" aria-hidden="true">${Te.map(u=>o`<span key=${u}>${u}</span>`)}</p></section>`}function Ge({series:{times:t,values:e},x:n,to:a}){let[i,c]=[Math.min(...e),Math.max(...e)],r=m=>c===i?I/2:4+(I-8)*(c-m)/(c-i),l=[...t.map((m,p)=>[n(m),r(e[p])]),[n(a),r(e.at(-1))]].map(m=>m.map(p=>p.toFixed(1)).join(","));return o`<path class="under" d=${`M${l[0].split(",")[0]},${I} L${l.join(" L")} L${N},${I}Z`} /><path class="line" d=${`M${l.join(" L")}`} />`}var He=350;function Ee(){return k.value&&E(k.value)?o`<${Ne} key=${k.value} id=${k.value} />`:null}function Ne({id:t}){let e=E(t).value,n=W(null),[a,i]=L(!1);C(()=>{n.current.focus();let l=setTimeout(()=>i(!0),He),m=p=>p.key==="Escape"&&G();return addEventListener("keydown",m),document.documentElement.classList.add("covered"),()=>{clearTimeout(l),removeEventListener("keydown",m),document.documentElement.classList.remove("covered"),setTimeout(pe)}},[]);let c=ce(e),r=oe("favorites",t);return o`<div class="shade" onClick=${()=>a&&G()}></div>
    <section ref=${n} class=${a?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${me(e)}`}><${h} path=${ue(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&ee(e.room),$e(e)].filter(Boolean).join(" \xB7 ")} <${ve} device=${e} /></p></div>
        ${y("act")&&o`<button type="button" class="round" aria-pressed=${String(r)} aria-label=${s("favorite")} onClick=${()=>ne("favorites",t,!r)}><${h} path=${r?f.star:f.starOff} /></button>`}
        <button type="button" class="round" aria-label=${s("close|do")} onClick=${G}><${h} path=${f.close} /></button></header>
      <div class="body">
        <${he} device=${e} />
        ${e.may_act&&(c.Main?o`<${c.Main} device=${e} />`:c.act?.(e)&&o`<div class="solo"><${le} device=${e} act=${c.act(e)} /></div>`)}
        <${be} device=${e} isShort />
        <${qe} device=${e} main=${c.main} />
        ${y("manage")&&o`<details class="part"><summary>${s("Name, room and tags")}</summary><${ge} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${s("Values, history, facts")} <${h} path=${f.right} /></a></p>
        <${Ce} device=${e} />
      </div>
    </section>`}function qe({device:t,main:e}){let[n,a]=L(null),i=$.value.state==="open",c=t.settable.filter(r=>!e.includes(r));return C(()=>{i&&c.length&&M("/discovery/find_devices",{ids:[t.id]}).then(r=>a(r.devices[0]),()=>{})},[t.id,i]),!c.length||!t.may_act?null:o`<details class="part" open=${e.length===0}><summary>${s("More controls")}</summary>${n&&o`<${fe} short=${t} device=${n} without=${e} />`}</details>`}var S=d(!1),Be={home:"Home",security:"Security",climate:"Climate",energy:"Energy"},Ie={plan:"Plan",routines:"Routines",journal:"Journal",system:"System"},P=({view:t,text:e,above:n,mark:a,name:i=""})=>o`<a href=${`#/${t}`} class=${i} aria-current=${t===n?"page":void 0}><${h} path=${f[t]} size=${26} /><span>${s(e)}</span>${a>0&&o`<b>${a}</b>`}</a>`;function _t({above:t,children:e}){let{state:n,reason:a}=$.value,i=n==="refused",c={home:K().length,security:ye(ae.value).length},r=l=>{l.preventDefault(),document.getElementById("content").focus()};return o`<div class="frame" inert=${!!k.value}>
      <a class="skip" href="#content" onClick=${r}>${s("to the content")}</a>
      <nav class="rail" aria-label=${s("views")}>
        ${Object.entries(Be).map(([l,m])=>o`<${P} key=${l} view=${l} text=${m} above=${t} mark=${c[l]} />`)}
        ${Object.entries(Ie).map(([l,m])=>o`<${P} key=${l} view=${l} text=${m} above=${t} name="last" />`)}
        <${P} view="more" text="More" above=${t in Ie?"more":t} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${n==="open"?"hidden":"notice"}>${n==="open"?s(F.value===1?"{count} device":"{count} devices",{count:F.value}):s(i?"not logged in":a||"connecting \u2026")}</p>
        ${(i||S.value||b.value)&&o`<${De} reason=${i?a:b.value} />`}
        ${se.value&&!F.value&&t!=="system"&&o`<p class="notice"><a href="#/setup">${s("No device is there yet: set up your home.")}</a></p>`}
        <${Se} />
        <main id="content" tabindex="-1" class=${n==="open"?"":"old"}>${e}</main>
      </div>
    </div>
    <${Ee} />
    <div class="told"><${we} />
      <p role="alert" class=${g.value?`outcome ${g.value.isGood?"good":"bad"}`:"hidden"}>
        ${g.value?.text} ${g.value?.override&&o`<button type="button" onClick=${g.value.override}>${s("Command it all the same?")}</button>`} ${g.value&&!g.value.isGood&&o`<button type="button" onClick=${()=>g.value=null}>${s("close|do")}</button>`}
      </p></div>`}function De({reason:t}){let e=n=>{n.preventDefault();let a=new FormData(n.target);S.value=!1,X(a.get("token").trim(),a.get("remember")==="on")};return o`<form class="card fields" aria-label=${s("log in")} onSubmit=${e}>
    ${t&&o`<p class="bad">${s(t)}</p>`}
    <p>${s("The code that homebot run prints lets a first screen in.")}</p>
    <p>${s("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${s("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${s("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${s("log in")}</button> ${t&&(w.value||t===V)&&o`<button type="button" onClick=${O}>${s("go on without a token")}</button>`} ${b.value&&o`<button type="button" onClick=${()=>b.value=""}>${s("not now")}</button>`}</p>
  </form>`}var Oe="homebot.theme",_e={"":"as the system",light:"light|theme",dark:"dark|theme"},q=d(localStorage.getItem(Oe)??"");x(()=>{localStorage.setItem(Oe,q.value),document.documentElement.dataset.theme=q.value});function Jt(){let t=w.value&&$.value.state!=="refused";return o`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${s("This screen")}</h2>
    <label><span>${s("Language")}</span> <select name="language" onChange=${e=>Y(e.target.value)}>${Object.entries(Z).map(([e,n])=>o`<option key=${e} value=${e} lang=${e} selected=${e===j.value}>${n}</option>`)}</select></label>
    <label><span>${s("Colors")}</span> <select name="theme" onChange=${e=>q.value=e.target.value}>${Object.entries(_e).map(([e,n])=>o`<option key=${e} value=${e} selected=${e===q.value}>${s(n)}</option>`)}</select></label>
    <p class="choices">${t?o`<button type="button" onClick=${O}>${s("log out")}</button>`:o`<button type="button" aria-expanded=${S.value} onClick=${()=>S.value=!S.value}>${s("log in")}</button>`}</p>
  </section>`}export{Xe as a,Ce as b,Ie as c,_t as d,Jt as e};
