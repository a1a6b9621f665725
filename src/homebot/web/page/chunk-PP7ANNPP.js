import{a as xe,b as we,c as Oe,d as Se,e as Ee}from"./chunk-PGV5EQGT.js";import{a as g,d as Y,e as f,f as fe,i as he,j as D,k as ve,m as E,n as ge,o as be,p as x,q as ye,r as ke,s as U}from"./chunk-7CATWXGU.js";import{a as v,b as G,k as N}from"./chunk-AQ3JQKM6.js";import{a as q,b as me,c as ue,d as k,f as pe,g as Z,h as $e,i as T,k as B,l as de}from"./chunk-6NAYE6O2.js";import{d as F,g as M,h as J,r as X}from"./chunk-UXC6REBR.js";import{A as H,C as ce,D as s,G as n,c as I,d as C,e as se,g as d,h as W,i as w,k as ae,l as re,m as $,n as b,o as y,p as O,q as ie,r as _,t as R,u as S,v as j,z as le}from"./chunk-QEF6ZHXC.js";var P=d([]),Le=d(!1);j("/alerts/findings",e=>{P.value=e.findings,Le.value=e.repeats});w(()=>{$.value.state==="connecting"&&(P.value=[])});var ee=()=>P.value.filter(e=>e.urgency!=="later");async function Ne(){let{success:e,message:t}=await S("/alerts/seen");N(e?s("Nobody is told of it again."):t,e)}function lt(){let e=P.value.filter(o=>o.urgency==="later"),t=ee();return n`
    ${t.map((o,a)=>n`<section key=${o.code} class="banner alarm" role="alert"><${f} path=${g.alert} size=${48} />
        <div>
          <h2>${s(o.title||"problem")}</h2>
          ${o.rows.map(r=>n`<p key=${r.what+r.why}>${k(r.what)&&n`<button type="button" class="link" onClick=${()=>ke(r.what)}>${de(r.what)}</button>`} ${(H.value==="en"||!r.what)&&r.why}</p>`)}
          ${o.next&&n`<p><strong>${s(o.next)}</strong></p>`}
        </div>
        ${a===t.length-1&&Le.value&&y("act")&&n`<button type="button" class="seen" onClick=${Ne}><${f} path=${g.check} /> ${s("I have seen it")}</button>`}
      </section>`)}
    ${e.length>0&&n`<p class="notes"><a href="#/system">${e.map(o=>`${s(o.title)}: ${o.total}`).join(" \xB7 ")}</a></p>`}`}var te=d([]),oe=d("");j("/control/questions",e=>{te.value=e.questions,oe.value=""});w(()=>{$.value.state==="connecting"&&(te.value=[])});async function qe({question:e},t){let{success:o,message:a}=await S("/control/answer",{question:e,yes:t});oe.value=a,!o&&!O.value&&(b.value=a)}var Ie=({text:e,problem:t,onAnswer:o})=>n`<section class="question" role="alert" aria-label=${s("question")}>
  <p><strong>${e}?</strong></p>
  ${y("act")&&n`<p class="buttons"><${fe} text=${s("do it")} onHeld=${()=>o(!0)} /> <button type="button" onClick=${()=>o(!1)}>${s("no")}</button></p>`}
  ${t&&n`<p class="bad">${t}</p>`}
</section>`;function Ce(){let{text:e,act:t}=G.value??{},o=a=>{G.value=null,a&&t()};return G.value&&n`<div class="agreement"><${Ie} text=${e} onAnswer=${o} /></div>`}var Me=()=>te.value.map(e=>n`<${Ie} key=${e.question} text=${e.text} problem=${oe.value} onAnswer=${t=>qe(e,t)} />`);var Te=24,[z,A]=[480,64],Be=["power","local_temperature","temperature","humidity","on_off","contact","occupancy","level","position","illuminance","battery"];function Ae({device:e,capability:t}){let o=t??Be.find(p=>[...e.states.values()].some(({capability:h,value:V})=>h===p&&V!==null)),[a,r]=I(null),c=$.value.state==="open";C(()=>{if(!o||!c)return;let p=ae(),h=p-Te*3600;R("/history/read",{device:e.id,capability:o,points:120,since:{sec:Math.floor(h),nanosec:0}}).then(V=>r({since:h,to:p,series:V.series.find(Ge=>Ge.times.length)}),()=>{})},[e.id,o,c]);let{series:i,since:l,to:m}=a??{};if(!i)return null;let u=p=>Math.max(0,z*(p-l)/(m-l)),K=`${J(o)}, ${X.value.format(l*1e3)} \u2013 ${s("now")}`,Fe=[0,1,2,3,4].map(p=>X.value.format((l+p*Te*3600/4)*1e3));return n`<section class="mini"><h3>${s("the last 24 hours")} <small>${J(o)}</small></h3>
    <svg viewBox=${`0 0 ${z} ${A}`} preserveAspectRatio="none" role="img" aria-label=${K}>${i.values.length?n`<${De} series=${i} x=${u} to=${m} />`:n`<rect class="base" y="20" width=${z} height="24" />${i.words.map((p,h)=>p==="true"&&n`<rect key=${h} class="on" y="20" height="24" x=${u(i.times[h])} width=${Math.max(2,u(i.ends[h])-u(i.times[h]))} />`)}`}</svg>
    ${i.values.length>0&&n`<p class="span"><span>${M(o,Math.min(...i.values))}</span><span>${M(o,Math.max(...i.values))}</span></p>`}
    <p class="axis" aria-hidden="true">${Fe.map(p=>n`<span key=${p}>${p}</span>`)}</p></section>`}function De({series:{times:e,values:t},x:o,to:a}){let[r,c]=[Math.min(...t),Math.max(...t)],i=m=>c===r?A/2:4+(A-8)*(c-m)/(c-r),l=[...e.map((m,u)=>[o(m),i(t[u])]),[o(a),i(t.at(-1))]].map(m=>m.map(u=>u.toFixed(1)).join(","));return n`<path class="under" d=${`M${l[0].split(",")[0]},${A} L${l.join(" L")} L${z},${A}Z`} /><path class="line" d=${`M${l.join(" L")}`} />`}var Ue=350;function _e(){return x.value&&k(x.value)?n`<${Pe} key=${x.value} id=${x.value} />`:null}function Pe({id:e}){let t=k(e).value,o=se(null),[a,r]=I(!1);C(()=>{o.current.focus();let m=setTimeout(()=>r(!0),Ue),u=K=>K.key==="Escape"&&U();return addEventListener("keydown",u),document.documentElement.classList.add("covered"),()=>{clearTimeout(m),removeEventListener("keydown",u),document.documentElement.classList.remove("covered"),setTimeout(ye)}},[]);let c=D(t),i=t.tags.includes(Z),l=async()=>{let{success:m,message:u}=await S("/discovery/tag",{device:e,tag:Z,remove:i});m||N(u,!1)};return n`<div class="shade" onClick=${()=>a&&U()}></div>
    <section ref=${o} class=${a?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${E(t)}`}><${f} path=${ge(t)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${t.name}</bdi></h2><p>${[t.room&&F(t.room),be(t)].filter(Boolean).join(" \xB7 ")} <${Oe} device=${t} /></p></div>
        ${y("manage")&&n`<button type="button" class="round" aria-pressed=${String(i)} aria-label=${s("favorite")} onClick=${l}><${f} path=${g.star} /></button>`}
        <button type="button" class="round" aria-label=${s("close|do")} onClick=${U}><${f} path=${g.close} /></button></header>
      <div class="body">
        <${we} device=${t} />
        ${t.may_act&&(c.Main?n`<${c.Main} device=${t} />`:c.act?.(t)&&n`<div class="solo"><${he} device=${t} act=${c.act(t)} /></div>`)}
        <${Ee} device=${t} isShort />
        <${ze} device=${t} main=${c.main} />
        ${y("manage")&&n`<details class="part"><summary>${s("Name, room and tags")}</summary><${Se} device=${t} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(e)}`}>${s("Values, history, facts")} <${f} path=${g.right} /></a></p>
        <${Ae} device=${t} />
      </div>
    </section>`}function ze({device:e,main:t}){let[o,a]=I(null),r=$.value.state==="open",c=e.settable.filter(i=>!t.includes(i));return C(()=>{r&&c.length&&R("/discovery/find_devices",{ids:[e.id]}).then(i=>a(i.devices[0]),()=>{})},[e.id,r]),!c.length||!e.may_act?null:n`<details class="part" open=${t.length===0}><summary>${s("More controls")}</summary>${o&&n`<${xe} short=${e} device=${o} without=${t} />`}</details>`}var Qe=/outside|outdoor|garden|balcon|terrace|au(ß|ss)en|draußen|garten|extérieur|exterior|jardin|jardín|buiten|tuin|esterno|giardino/i,Ke=e=>E(e)==="open",Kt=e=>e.type==="light"&&D(e).isActive(e),Vt=W(()=>ue.value.map(([e,t])=>[e,t.filter(o=>!pe(o)).map(o=>k(o)?.value).filter(o=>o&&!ve(o))]).filter(([,e])=>e.length)),Wt=W(()=>B.value.filter(e=>e.type==="x_person"||e.type==="x_tracker")),Jt=e=>T(e,"at_home")??T(e,"place")==="home",Ve=["local_temperature","temperature"],We=new Set(["thermostat","room_air_conditioner","temperature_sensor","air_quality_sensor","humidity_sensor","occupancy_sensor"]);function Xt(e,t=Ve){let o=e.filter(a=>We.has(a.type)&&E(a)!=="silent").map(a=>t.map(r=>T(a,r)).find(r=>typeof r=="number")).filter(a=>a!==void 0);return o.length?o.reduce((a,r)=>a+r,0)/o.length:void 0}var Zt=e=>M("temperature",Math.round(10*e)/10),Yt=e=>Qe.test(`${e.room} ${e.name}`),Je=e=>e.room&&!e.name.toLowerCase().includes(e.room.toLowerCase())&&/^(window|door|fenster|tür|fenêtre|porte|ventana|puerta|raam|deur|finestra|porta)$/i.test(e.name)?`${F(e.room)}: ${e.name}`:e.name,eo=e=>e.length?s(e[0].type==="door_lock"?"{name} unlocked":"{name} open",{name:Je(e[0])})+(e.length>1?`, +${e.length-1}`:""):s("all closed"),Re=e=>e.filter(Ke).sort((t,o)=>(Y(t)==="window")-(Y(o)==="window")),to=e=>e.filter(t=>$e(t,"power")&&E(t)!=="silent").reduce((t,o)=>t+Math.max(0,T(o,"power")),0);var L=d(!1),Xe={home:"Home",security:"Security",climate:"Climate",energy:"Energy"},je={plan:"Plan",routines:"Routines",journal:"Journal",system:"System"},ne=({view:e,text:t,above:o,mark:a,name:r=""})=>n`<a href=${`#/${e}`} class=${r} aria-current=${e===o?"page":void 0}><${f} path=${g[e]} size=${26} /><span>${s(t)}</span>${a>0&&n`<b>${a}</b>`}</a>`;function ho({above:e,children:t}){let{state:o,reason:a}=$.value,r=o==="refused",c={home:ee().length,security:Re(B.value).length},i=l=>{l.preventDefault(),document.getElementById("content").focus()};return n`<div class="frame" inert=${!!x.value}>
      <a class="skip" href="#content" onClick=${i}>${s("to the content")}</a>
      <nav class="rail" aria-label=${s("views")}>
        ${Object.entries(Xe).map(([l,m])=>n`<${ne} key=${l} view=${l} text=${m} above=${e} mark=${c[l]} />`)}
        ${Object.entries(je).map(([l,m])=>n`<${ne} key=${l} view=${l} text=${m} above=${e} name="last" />`)}
        <${ne} view="more" text="More" above=${e in je?"more":e} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${o==="open"?"hidden":"notice"}>${o==="open"?s(q.value===1?"{count} device":"{count} devices",{count:q.value}):s(r?"not logged in":a||"connecting \u2026")}</p>
        ${(r||L.value||b.value)&&n`<${Ze} reason=${r?a:b.value} />`}
        ${me.value&&!q.value&&e!=="system"&&n`<p class="notice"><a href="#/setup">${s("No device is there yet: set up your home.")}</a></p>`}
        <${Me} />
        <main id="content" tabindex="-1" class=${o==="open"?"":"old"}>${t}</main>
      </div>
    </div>
    <${_e} />
    <div class="told"><${Ce} />
      <p role="alert" class=${v.value?`outcome ${v.value.isGood?"good":"bad"}`:"hidden"}>
        ${v.value?.text} ${v.value?.override&&n`<button type="button" onClick=${v.value.override}>${s("Command it all the same?")}</button>`} ${v.value&&!v.value.isGood&&n`<button type="button" onClick=${()=>v.value=null}>${s("close|do")}</button>`}
      </p></div>`}function Ze({reason:e}){let t=o=>{o.preventDefault();let a=new FormData(o.target);L.value=!1,ie(a.get("token").trim(),a.get("remember")==="on")};return n`<form class="card fields" aria-label=${s("log in")} onSubmit=${t}>
    ${e&&n`<p class="bad">${s(e)}</p>`}
    <p>${s("The code that homebot run prints lets a first screen in.")}</p>
    <p>${s("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${s("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${s("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${s("log in")}</button> ${e&&(O.value||e===re)&&n`<button type="button" onClick=${_}>${s("go on without a token")}</button>`} ${b.value&&n`<button type="button" onClick=${()=>b.value=""}>${s("not now")}</button>`}</p>
  </form>`}var He="homebot.theme",Ye={"":"as the system",light:"light|theme",dark:"dark|theme"},Q=d(localStorage.getItem(He)??"");w(()=>{localStorage.setItem(He,Q.value),document.documentElement.dataset.theme=Q.value});function wo(){let e=O.value&&$.value.state!=="refused";return n`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${s("This screen")}</h2>
    <label><span>${s("Language")}</span> <select name="language" onChange=${t=>ce(t.target.value)}>${Object.entries(le).map(([t,o])=>n`<option key=${t} value=${t} lang=${t} selected=${t===H.value}>${o}</option>`)}</select></label>
    <label><span>${s("Colors")}</span> <select name="theme" onChange=${t=>Q.value=t.target.value}>${Object.entries(Ye).map(([t,o])=>n`<option key=${t} value=${t} selected=${t===Q.value}>${s(o)}</option>`)}</select></label>
    <p class="choices">${e?n`<button type="button" onClick=${_}>${s("log out")}</button>`:n`<button type="button" aria-expanded=${L.value} onClick=${()=>L.value=!L.value}>${s("log in")}</button>`}</p>
  </section>`}export{lt as a,Ae as b,Ke as c,Kt as d,Vt as e,Wt as f,Jt as g,Xt as h,Zt as i,Yt as j,Je as k,eo as l,Re as m,to as n,je as o,ho as p,wo as q};
