import{a as x,d as z,e as S}from"./chunk-KPBWHYEH.js";import{a as w}from"./chunk-23RNGWL3.js";import{c as Q,l as W}from"./chunk-NVFS5PHO.js";import{a as M,h as N,j as P}from"./chunk-VTZC2C7Y.js";import{k as b,l as U,t as B}from"./chunk-CMGFQJRK.js";import{a as l,b as h}from"./chunk-MZBGLNIX.js";import{d as D,t as F}from"./chunk-GVOJYK5O.js";import{B as R,C as j,E as G,F as t,I as n,h as r,j as v,m as E,n as m,o as y,p as c,q as T,r as p,s as O,t as g,w as q,x as H}from"./chunk-DKKXXYSS.js";var C=r([]),I=r("");H("/control/questions",o=>{C.value=o.questions,I.value=""});v(()=>{m.value.state==="connecting"&&(C.value=[])});async function te({question:o},e){let{success:a,message:s}=await q("/control/answer",{question:o,yes:e});I.value=s,!a&&!p.value&&(c.value=s)}var J=({text:o,problem:e,onAnswer:a})=>n`<section class="question" role="alert" aria-label=${t("question")}>
  <p><strong>${o}?</strong></p>
  ${T("act")&&n`<p class="buttons"><${P} text=${t("do it")} onHeld=${()=>a(!0)} /> <button type="button" onClick=${()=>a(!1)}>${t("no")}</button></p>`}
  ${e&&n`<p class="bad">${e}</p>`}
</section>`;function X(){let{text:o,act:e}=h.value??{},a=s=>{h.value=null,s&&e()};return h.value&&n`<div class="agreement"><${J} text=${o} onAnswer=${a} /></div>`}var K=()=>C.value.map(o=>n`<${J} key=${o.question} text=${o.text} problem=${I.value} onAnswer=${e=>te(o,e)} />`);var oe=x(async()=>(await import("./sheet-BB5ATUPT.js")).Sheet),ne=x(async()=>(await import("./wall-GTSH3RBL.js")).Wall),$=r(!1),ae=S({home:"Home",security:"Security",climate:"Climate"}),V=S({plan:"Plan",journal:"Journal",system:"System"}),A=({view:o,text:e,above:a,mark:s,name:d=""})=>n`<a href=${`#/${o}`} class=${d} aria-current=${o===a?"page":void 0}><${N} path=${M[o]} size=${26} /><span>${t(e)}</span>${s>0&&n`<b>${s}</b>`}</a>`;function Le({above:o,children:e}){let{state:a,reason:s}=m.value,d=a==="refused",_={home:z().length,security:W(B.value).length},ee=i=>{i.preventDefault(),document.getElementById("content").focus()};return n`<div class="frame" inert=${!!w.value}>
      <a class="skip" href="#content" onClick=${ee}>${t("to the content")}</a>
      <nav class="rail" aria-label=${t("views")}>
        ${Object.entries(ae).map(([i,k])=>n`<${A} key=${i} view=${i} text=${k} above=${o} mark=${_[i]} />`)}
        ${Object.entries(V).map(([i,k])=>n`<${A} key=${i} view=${i} text=${k} above=${o} name="last" />`)}
        <${A} view="more" text="More" above=${o in V?"more":o} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${a==="open"?"hidden":"notice"}>${a==="open"?t(b.value===1?"{count} device":"{count} devices",{count:b.value}):d?t("not logged in"):s&&y.value?t("homebot cannot be reached since {time}: perhaps it is restarting.",{time:F({sec:y.value,nanosec:0})}):t(s||"connecting \u2026")}</p>
        ${(d||$.value||c.value)&&n`<${se} reason=${d?s:c.value} />`}
        ${U.value&&!b.value&&o!=="system"&&n`<p class="notice"><a href="#/setup">${t("No device is there yet: set up your home.")}</a></p>`}
        <${K} />
        <main id="content" tabindex="-1" class=${a==="open"?"":"old"}>${e}</main>
      </div>
    </div>
    ${w.value&&n`<${oe} />`}
    ${u.value&&n`<${ne} />`}
    <div class="told"><${X} />
      <p role="alert" class=${l.value?`outcome ${l.value.isGood?"good":"bad"}`:"hidden"}>
        ${l.value?.text} ${l.value?.override&&n`<button type="button" onClick=${l.value.override}>${t("Command it all the same?")}</button>`} ${l.value&&!l.value.isGood&&n`<button type="button" onClick=${()=>l.value=null}>${t("close|do")}</button>`}
      </p></div>`}function se({reason:o}){let e=a=>{a.preventDefault();let s=new FormData(a.target);$.value=!1,O(s.get("token").trim(),s.get("remember")==="on")};return n`<form class="card fields" aria-label=${t("log in")} onSubmit=${e}>
    ${o&&n`<p class="bad">${t(o)}</p>`}
    <p>${t("The code that homebot run prints lets a first screen in.")}</p>
    <p>${t("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${t("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${t("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${t("log in")}</button> ${o&&(p.value||o===E)&&n`<button type="button" onClick=${g}>${t("go on without a token")}</button>`} ${c.value&&n`<button type="button" onClick=${()=>c.value=""}>${t("not now")}</button>`}</p>
  </form>`}var Y="homebot.theme",le={"":"as the system",light:"light|theme",dark:"dark|theme"},f=r(localStorage.getItem(Y)??"");v(()=>{localStorage.setItem(Y,f.value),document.documentElement.dataset.theme=f.value});var Z="homebot.wall",L=new URLSearchParams(location.search).get("wall"),u=r(L===null?localStorage.getItem(Z)??"":L==="off"?"":L||"home");v(()=>localStorage.setItem(Z,u.value));var De=o=>o&&o!=="home"?`#/room/${encodeURIComponent(o)}`:"#/home";function Fe(){let o=p.value&&m.value.state!=="refused";return n`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${t("This screen")}</h2>
    <label><span>${t("Language")}</span> <select name="language" onChange=${e=>G(e.target.value)}>${Object.entries(R).map(([e,a])=>n`<option key=${e} value=${e} lang=${e} selected=${e===j.value}>${a}</option>`)}</select></label>
    <label><span>${t("Colors")}</span> <select name="theme" onChange=${e=>f.value=e.target.value}>${Object.entries(le).map(([e,a])=>n`<option key=${e} value=${e} selected=${e===f.value}>${t(a)}</option>`)}</select></label>
    <label><span>${t("At a wall")}</span> <select name="wall" onChange=${e=>u.value=e.target.value}>${[["",t("no")],["home",t("begins with {view}",{view:t("Home")})],...Q.value.filter(([e])=>e).map(([e])=>[e,t("begins with {view}",{view:D(e)})])].map(([e,a])=>n`<option key=${e} value=${e} selected=${e===u.value}>${a}</option>`)}</select></label>
    ${u.value&&n`<p class="legend">${t("After five minutes it shows a dim clock and what is open. The address of this screen:")} <code>${`${location.origin}/?wall=${encodeURIComponent(u.value)}`}</code></p>`}
    <p class="choices">${o?n`<button type="button" onClick=${g}>${t("log out")}</button>`:n`<button type="button" aria-expanded=${$.value} onClick=${()=>$.value=!$.value}>${t("log in")}</button>`}</p>
  </section>`}export{u as a,De as b,Fe as c,V as d,Le as e};
