import{a as me,b as ue,c as $e,d as pe,e as de}from"./chunk-Y2T3TGFD.js";import{a as se,c as re,d as ce,e as F}from"./chunk-QOFKBFII.js";import{c as le,l as ie}from"./chunk-QBZ6BA7O.js";import{a as f,b as ae,d as L}from"./chunk-GLCKL2HZ.js";import{a as d,h as v,j as Y,m as Z,n as ee,q as te,r as oe,s as ne}from"./chunk-N2Y6UGSU.js";import{d as z,g as J,k as I,l as V,n as R,t as X}from"./chunk-ZPSP65LU.js";import{a as m,b as C}from"./chunk-RMSJOTTF.js";import{d as S,t as _}from"./chunk-BEVGLSVT.js";import{B as K,C as P,E as Q,F as o,I as n,c as A,d as E,f as G,h as u,j as k,m as H,n as $,o as T,p,q as w,r as b,s as D,t as x,v as N,w as U,x as W}from"./chunk-UMKYRW5X.js";var q=u([]),M=u("");W("/control/questions",t=>{q.value=t.questions,M.value=""});k(()=>{$.value.state==="connecting"&&(q.value=[])});async function xe({question:t},e){let{success:a,message:s}=await U("/control/answer",{question:t,yes:e});M.value=s,!a&&!b.value&&(p.value=s)}var ve=({text:t,problem:e,onAnswer:a})=>n`<section class="question" role="alert" aria-label=${o("question")}>
  <p><strong>${t}?</strong></p>
  ${w("act")&&n`<p class="buttons"><${Y} text=${o("do it")} onHeld=${()=>a(!0)} /> <button type="button" onClick=${()=>a(!1)}>${o("no")}</button></p>`}
  ${e&&n`<p class="bad">${e}</p>`}
</section>`;function fe(){let{text:t,act:e}=C.value??{},a=s=>{C.value=null,s&&e()};return C.value&&n`<div class="agreement"><${ve} text=${t} onAnswer=${a} /></div>`}var he=()=>q.value.map(t=>n`<${ve} key=${t.question} text=${t.text} problem=${M.value} onAnswer=${e=>xe(t,e)} />`);var Se=350;function ge(){return f.value&&R(f.value)?n`<${Ce} key=${f.value} id=${f.value} />`:null}function Ce({id:t}){let e=R(t).value,a=G(null),[s,l]=A(!1);E(()=>{a.current.focus();let r=setTimeout(()=>l(!0),Se),g=we=>we.key==="Escape"&&L();return addEventListener("keydown",g),document.documentElement.classList.add("covered"),()=>{clearTimeout(r),removeEventListener("keydown",g),document.documentElement.classList.remove("covered"),setTimeout(ae)}},[]);let i=ee(e),c=z("favorites",t);return n`<div class="shade" onClick=${()=>s&&L()}></div>
    <section ref=${a} class=${s?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${te(e)}`}><${v} path=${oe(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&S(e.room),ne(e)].filter(Boolean).join(" \xB7 ")} <${$e} device=${e} /></p></div>
        ${w("act")&&n`<button type="button" class="round" aria-pressed=${String(c)} aria-label=${o("favorite")} onClick=${()=>J("favorites",t,!c)}><${v} path=${c?d.star:d.starOff} /></button>`}
        <button type="button" class="round" aria-label=${o("close|do")} onClick=${L}><${v} path=${d.close} /></button></header>
      <div class="body">
        <${ue} device=${e} />
        ${e.may_act&&(i.Main?n`<${i.Main} device=${e} />`:i.act?.(e)&&n`<div class="solo"><${Z} device=${e} act=${i.act(e)} /></div>`)}
        <${de} device=${e} isShort />
        <${Ie} device=${e} main=${i.main} />
        ${w("manage")&&n`<details class="part"><summary>${o("Name, room and tags")}</summary><${pe} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${o("Values, history, facts")} <${v} path=${d.right} /></a></p>
        <${re} at="day" device=${e} />
      </div>
    </section>`}function Ie({device:t,main:e}){let[a,s]=A(null),l=$.value.state==="open",i=t.settable.filter(c=>!e.includes(c));return E(()=>{l&&i.length&&N("/discovery/find_devices",{ids:[t.id]}).then(c=>s(c.devices[0]),()=>{})},[t.id,l]),!i.length||!t.may_act?null:n`<details class="part" open=${e.length===0}><summary>${o("More controls")}</summary>${a&&n`<${me} short=${t} device=${a} without=${e} />`}</details>`}var Le=se(async()=>(await import("./wall-VPNFTLS6.js")).Wall),y=u(!1),Oe=F({home:"Home",security:"Security",climate:"Climate"}),be=F({plan:"Plan",journal:"Journal",system:"System"}),j=({view:t,text:e,above:a,mark:s,name:l=""})=>n`<a href=${`#/${t}`} class=${l} aria-current=${t===a?"page":void 0}><${v} path=${d[t]} size=${26} /><span>${o(e)}</span>${s>0&&n`<b>${s}</b>`}</a>`;function ft({above:t,children:e}){let{state:a,reason:s}=$.value,l=a==="refused",i={home:ce().length,security:ie(X.value).length},c=r=>{r.preventDefault(),document.getElementById("content").focus()};return n`<div class="frame" inert=${!!f.value}>
      <a class="skip" href="#content" onClick=${c}>${o("to the content")}</a>
      <nav class="rail" aria-label=${o("views")}>
        ${Object.entries(Oe).map(([r,g])=>n`<${j} key=${r} view=${r} text=${g} above=${t} mark=${i[r]} />`)}
        ${Object.entries(be).map(([r,g])=>n`<${j} key=${r} view=${r} text=${g} above=${t} name="last" />`)}
        <${j} view="more" text="More" above=${t in be?"more":t} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${a==="open"?"hidden":"notice"}>${a==="open"?o(I.value===1?"{count} device":"{count} devices",{count:I.value}):l?o("not logged in"):s&&T.value?o("homebot cannot be reached since {time}: perhaps it is restarting.",{time:_({sec:T.value,nanosec:0})}):o(s||"connecting \u2026")}</p>
        ${(l||y.value||p.value)&&n`<${Ae} reason=${l?s:p.value} />`}
        ${V.value&&!I.value&&t!=="system"&&n`<p class="notice"><a href="#/setup">${o("No device is there yet: set up your home.")}</a></p>`}
        <${he} />
        <main id="content" tabindex="-1" class=${a==="open"?"":"old"}>${e}</main>
      </div>
    </div>
    <${ge} />
    ${h.value&&n`<${Le} />`}
    <div class="told"><${fe} />
      <p role="alert" class=${m.value?`outcome ${m.value.isGood?"good":"bad"}`:"hidden"}>
        ${m.value?.text} ${m.value?.override&&n`<button type="button" onClick=${m.value.override}>${o("Command it all the same?")}</button>`} ${m.value&&!m.value.isGood&&n`<button type="button" onClick=${()=>m.value=null}>${o("close|do")}</button>`}
      </p></div>`}function Ae({reason:t}){let e=a=>{a.preventDefault();let s=new FormData(a.target);y.value=!1,D(s.get("token").trim(),s.get("remember")==="on")};return n`<form class="card fields" aria-label=${o("log in")} onSubmit=${e}>
    ${t&&n`<p class="bad">${o(t)}</p>`}
    <p>${o("The code that homebot run prints lets a first screen in.")}</p>
    <p>${o("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${o("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${o("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${o("log in")}</button> ${t&&(b.value||t===H)&&n`<button type="button" onClick=${x}>${o("go on without a token")}</button>`} ${p.value&&n`<button type="button" onClick=${()=>p.value=""}>${o("not now")}</button>`}</p>
  </form>`}var ye="homebot.theme",Ee={"":"as the system",light:"light|theme",dark:"dark|theme"},O=u(localStorage.getItem(ye)??"");k(()=>{localStorage.setItem(ye,O.value),document.documentElement.dataset.theme=O.value});var ke="homebot.wall",B=new URLSearchParams(location.search).get("wall"),h=u(B===null?localStorage.getItem(ke)??"":B==="off"?"":B||"home");k(()=>localStorage.setItem(ke,h.value));var Ct=t=>t&&t!=="home"?`#/room/${encodeURIComponent(t)}`:"#/home";function It(){let t=b.value&&$.value.state!=="refused";return n`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${o("This screen")}</h2>
    <label><span>${o("Language")}</span> <select name="language" onChange=${e=>Q(e.target.value)}>${Object.entries(K).map(([e,a])=>n`<option key=${e} value=${e} lang=${e} selected=${e===P.value}>${a}</option>`)}</select></label>
    <label><span>${o("Colors")}</span> <select name="theme" onChange=${e=>O.value=e.target.value}>${Object.entries(Ee).map(([e,a])=>n`<option key=${e} value=${e} selected=${e===O.value}>${o(a)}</option>`)}</select></label>
    <label><span>${o("At a wall")}</span> <select name="wall" onChange=${e=>h.value=e.target.value}>${[["",o("no")],["home",o("begins with {view}",{view:o("Home")})],...le.value.filter(([e])=>e).map(([e])=>[e,o("begins with {view}",{view:S(e)})])].map(([e,a])=>n`<option key=${e} value=${e} selected=${e===h.value}>${a}</option>`)}</select></label>
    ${h.value&&n`<p class="legend">${o("After five minutes it shows a dim clock and what is open. The address of this screen:")} <code>${`${location.origin}/?wall=${encodeURIComponent(h.value)}`}</code></p>`}
    <p class="choices">${t?n`<button type="button" onClick=${x}>${o("log out")}</button>`:n`<button type="button" aria-expanded=${y.value} onClick=${()=>y.value=!y.value}>${o("log in")}</button>`}</p>
  </section>`}export{h as a,Ct as b,It as c,be as d,ft as e};
