import{a as he,b as ge,c as be,d as ye,e as ke}from"./chunk-ZKJLJWOM.js";import{a as pe,c as fe,d as ve,e as N}from"./chunk-PLUCCOJL.js";import{c as $e,l as de}from"./chunk-6ITVNAEV.js";import{a as h,b as ue,d as T}from"./chunk-W54ORNDN.js";import{a as f,h as v,j as se,m as re,n as ie,q as le,r as ce,s as me}from"./chunk-CHSJDUJ6.js";import{d as te,g as oe,k as L,l as ne,n as M,t as ae}from"./chunk-CMGFQJRK.js";import{a as $,b as A}from"./chunk-MZBGLNIX.js";import{d as O,t as ee}from"./chunk-GVOJYK5O.js";import{B as J,C as V,E as Y,F as o,G as Z,I as n,c as k,d as w,f as U,h as m,j as x,m as W,n as u,o as F,p as d,q as S,r as b,s as K,t as I,u as Q,v as C,w as z,x as X}from"./chunk-DKKXXYSS.js";var P=m([]),q=m("");X("/control/questions",t=>{P.value=t.questions,q.value=""});x(()=>{u.value.state==="connecting"&&(P.value=[])});async function Me({question:t},e){let{success:a,message:s}=await z("/control/answer",{question:t,yes:e});q.value=s,!a&&!b.value&&(d.value=s)}var we=({text:t,problem:e,onAnswer:a})=>n`<section class="question" role="alert" aria-label=${o("question")}>
  <p><strong>${t}?</strong></p>
  ${S("act")&&n`<p class="buttons"><${se} text=${o("do it")} onHeld=${()=>a(!0)} /> <button type="button" onClick=${()=>a(!1)}>${o("no")}</button></p>`}
  ${e&&n`<p class="bad">${e}</p>`}
</section>`;function xe(){let{text:t,act:e}=A.value??{},a=s=>{A.value=null,s&&e()};return A.value&&n`<div class="agreement"><${we} text=${t} onAnswer=${a} /></div>`}var Se=()=>P.value.map(t=>n`<${we} key=${t.question} text=${t.text} problem=${q.value} onAnswer=${e=>Me(t,e)} />`);var Ne=2e3,Pe=15e3,qe=15,Ce=m([]);Q(()=>C("/page/pictures").then(t=>Ce.value=t.names,()=>{}));var Ee=(t,e)=>[t.id,t.name,t.given].some(a=>a.toLowerCase()===e.toLowerCase()),st=(t,e)=>t.some(a=>Ee(a,e)),D=t=>t.type==="camera"||Ce.value.some(e=>Ee(t,e));function Ie({of:t,text:e,isExtra:a=!1}){let[s,c]=k({source:"",problem:""}),l=u.value.state==="open";w(()=>{if(!l)return;let p=0,E=!0,B=async()=>{let{success:H,message:Re,media_type:_e,data:Fe}=await C("/page/picture",{device:t},qe).catch(_=>({message:_.message}));E&&(c(_=>H?{source:`data:${_e};base64,${Fe}`,problem:""}:{..._,problem:Re}),p=setTimeout(B,H&&!a?Ne:Pe))};return B(),()=>{E=!1,clearTimeout(p)}},[t,l]);let{source:i,problem:r}=s;return a&&(!i||r)?null:n`<figure class="picture">${i?n`<img src=${i} alt=${e} class=${r?"old":""} />`:n`<span class="pane"></span>`}
    ${r&&n`<figcaption>${i?o("This picture is no longer new."):o("There is no picture.")} <small>${Z(r)}</small></figcaption>`}</figure>`}var De=new Set(["video_player","speaker","robotic_vacuum_cleaner","x_lawn_mower","generic_switch"]),Ge=350;function Oe(){return h.value&&M(h.value)?n`<${je} key=${h.value} id=${h.value} />`:null}function je({id:t}){let e=M(t).value,a=U(null),[s,c]=k(!1);w(()=>{a.current.focus();let r=setTimeout(()=>c(!0),Ge),p=E=>E.key==="Escape"&&T();return addEventListener("keydown",p),document.documentElement.classList.add("covered"),()=>{clearTimeout(r),removeEventListener("keydown",p),document.documentElement.classList.remove("covered"),setTimeout(ue)}},[]);let l=ie(e),i=te("favorites",t);return n`<div class="shade" onClick=${()=>s&&T()}></div>
    <section ref=${a} class=${s?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${le(e)}`}><${v} path=${ce(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&O(e.room),me(e)].filter(Boolean).join(" \xB7 ")} <${be} device=${e} /></p></div>
        ${S("act")&&n`<button type="button" class="round" aria-pressed=${String(i)} aria-label=${o("favorite")} onClick=${()=>oe("favorites",t,!i)}><${v} path=${i?f.star:f.starOff} /></button>`}
        <button type="button" class="round" aria-label=${o("close|do")} onClick=${T}><${v} path=${f.close} /></button></header>
      <div class="body">
        <${ge} device=${e} />
        ${(D(e)||De.has(e.type))&&n`<${Ie} of=${t} text=${e.name} isExtra=${!D(e)} />`}
        ${e.may_act&&(l.Main?n`<${l.Main} device=${e} />`:l.act?.(e)&&n`<div class="solo"><${re} device=${e} act=${l.act(e)} /></div>`)}
        <${ke} device=${e} isShort />
        <${Be} device=${e} main=${l.main} />
        ${S("manage")&&n`<details class="part"><summary>${o("Name, room and tags")}</summary><${ye} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${o("Values, history, facts")} <${v} path=${f.right} /></a></p>
        <${fe} at="day" device=${e} />
      </div>
    </section>`}function Be({device:t,main:e}){let[a,s]=k(null),c=u.value.state==="open",l=t.settable.filter(i=>!e.includes(i));return w(()=>{c&&l.length&&C("/discovery/find_devices",{ids:[t.id]}).then(i=>s(i.devices[0]),()=>{})},[t.id,c]),!l.length||!t.may_act?null:n`<details class="part" open=${e.length===0}><summary>${o("More controls")}</summary>${a&&n`<${he} short=${t} device=${a} without=${e} />`}</details>`}var He=pe(async()=>(await import("./wall-LHKMKO6L.js")).Wall),y=m(!1),Ue=N({home:"Home",security:"Security",climate:"Climate"}),Ae=N({plan:"Plan",journal:"Journal",system:"System"}),G=({view:t,text:e,above:a,mark:s,name:c=""})=>n`<a href=${`#/${t}`} class=${c} aria-current=${t===a?"page":void 0}><${v} path=${f[t]} size=${26} /><span>${o(e)}</span>${s>0&&n`<b>${s}</b>`}</a>`;function Gt({above:t,children:e}){let{state:a,reason:s}=u.value,c=a==="refused",l={home:ve().length,security:de(ae.value).length},i=r=>{r.preventDefault(),document.getElementById("content").focus()};return n`<div class="frame" inert=${!!h.value}>
      <a class="skip" href="#content" onClick=${i}>${o("to the content")}</a>
      <nav class="rail" aria-label=${o("views")}>
        ${Object.entries(Ue).map(([r,p])=>n`<${G} key=${r} view=${r} text=${p} above=${t} mark=${l[r]} />`)}
        ${Object.entries(Ae).map(([r,p])=>n`<${G} key=${r} view=${r} text=${p} above=${t} name="last" />`)}
        <${G} view="more" text="More" above=${t in Ae?"more":t} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${a==="open"?"hidden":"notice"}>${a==="open"?o(L.value===1?"{count} device":"{count} devices",{count:L.value}):c?o("not logged in"):s&&F.value?o("homebot cannot be reached since {time}: perhaps it is restarting.",{time:ee({sec:F.value,nanosec:0})}):o(s||"connecting \u2026")}</p>
        ${(c||y.value||d.value)&&n`<${We} reason=${c?s:d.value} />`}
        ${ne.value&&!L.value&&t!=="system"&&n`<p class="notice"><a href="#/setup">${o("No device is there yet: set up your home.")}</a></p>`}
        <${Se} />
        <main id="content" tabindex="-1" class=${a==="open"?"":"old"}>${e}</main>
      </div>
    </div>
    <${Oe} />
    ${g.value&&n`<${He} />`}
    <div class="told"><${xe} />
      <p role="alert" class=${$.value?`outcome ${$.value.isGood?"good":"bad"}`:"hidden"}>
        ${$.value?.text} ${$.value?.override&&n`<button type="button" onClick=${$.value.override}>${o("Command it all the same?")}</button>`} ${$.value&&!$.value.isGood&&n`<button type="button" onClick=${()=>$.value=null}>${o("close|do")}</button>`}
      </p></div>`}function We({reason:t}){let e=a=>{a.preventDefault();let s=new FormData(a.target);y.value=!1,K(s.get("token").trim(),s.get("remember")==="on")};return n`<form class="card fields" aria-label=${o("log in")} onSubmit=${e}>
    ${t&&n`<p class="bad">${o(t)}</p>`}
    <p>${o("The code that homebot run prints lets a first screen in.")}</p>
    <p>${o("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${o("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${o("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${o("log in")}</button> ${t&&(b.value||t===W)&&n`<button type="button" onClick=${I}>${o("go on without a token")}</button>`} ${d.value&&n`<button type="button" onClick=${()=>d.value=""}>${o("not now")}</button>`}</p>
  </form>`}var Le="homebot.theme",Ke={"":"as the system",light:"light|theme",dark:"dark|theme"},R=m(localStorage.getItem(Le)??"");x(()=>{localStorage.setItem(Le,R.value),document.documentElement.dataset.theme=R.value});var Te="homebot.wall",j=new URLSearchParams(location.search).get("wall"),g=m(j===null?localStorage.getItem(Te)??"":j==="off"?"":j||"home");x(()=>localStorage.setItem(Te,g.value));var Xt=t=>t&&t!=="home"?`#/room/${encodeURIComponent(t)}`:"#/home";function Jt(){let t=b.value&&u.value.state!=="refused";return n`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${o("This screen")}</h2>
    <label><span>${o("Language")}</span> <select name="language" onChange=${e=>Y(e.target.value)}>${Object.entries(J).map(([e,a])=>n`<option key=${e} value=${e} lang=${e} selected=${e===V.value}>${a}</option>`)}</select></label>
    <label><span>${o("Colors")}</span> <select name="theme" onChange=${e=>R.value=e.target.value}>${Object.entries(Ke).map(([e,a])=>n`<option key=${e} value=${e} selected=${e===R.value}>${o(a)}</option>`)}</select></label>
    <label><span>${o("At a wall")}</span> <select name="wall" onChange=${e=>g.value=e.target.value}>${[["",o("no")],["home",o("begins with {view}",{view:o("Home")})],...$e.value.filter(([e])=>e).map(([e])=>[e,o("begins with {view}",{view:O(e)})])].map(([e,a])=>n`<option key=${e} value=${e} selected=${e===g.value}>${a}</option>`)}</select></label>
    ${g.value&&n`<p class="legend">${o("After five minutes it shows a dim clock and what is open. The address of this screen:")} <code>${`${location.origin}/?wall=${encodeURIComponent(g.value)}`}</code></p>`}
    <p class="choices">${t?n`<button type="button" onClick=${I}>${o("log out")}</button>`:n`<button type="button" aria-expanded=${y.value} onClick=${()=>y.value=!y.value}>${o("log in")}</button>`}</p>
  </section>`}export{g as a,Xt as b,Jt as c,Ce as d,st as e,D as f,Ie as g,Ae as h,Gt as i};
