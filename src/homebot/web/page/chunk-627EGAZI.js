import{a as ie,b as re,c as le,d as ce,e as ue}from"./chunk-Y7GONJIA.js";import{c as ae,d as se,e as T}from"./chunk-4XRYE4FN.js";import{l as ne}from"./chunk-24Q6OJX7.js";import{a as v,b as oe,d as C}from"./chunk-3WFHMPTW.js";import{a as d,h as f,j as W,m as X,n as Y,q as Z,r as ee,s as te}from"./chunk-T7HJ6HO6.js";import{d as P,g as U,k as w,l as J,n as A,t as V}from"./chunk-E4ZU5TWP.js";import{a as u,b as S}from"./chunk-YB32CKE5.js";import{d as _,t as z}from"./chunk-Q45TKNX5.js";import{B as N,C as K,E as Q,F as o,I as n,c as O,d as I,f as R,h as $,j as k,m as j,n as m,o as L,p,q as y,r as b,s as B,t as x,v as G,w as D,x as H}from"./chunk-E5CCYWQY.js";var F=$([]),M=$("");H("/control/questions",t=>{F.value=t.questions,M.value=""});k(()=>{m.value.state==="connecting"&&(F.value=[])});async function be({question:t},e){let{success:a,message:s}=await D("/control/answer",{question:t,yes:e});M.value=s,!a&&!b.value&&(p.value=s)}var me=({text:t,problem:e,onAnswer:a})=>n`<section class="question" role="alert" aria-label=${o("question")}>
  <p><strong>${t}?</strong></p>
  ${y("act")&&n`<p class="buttons"><${W} text=${o("do it")} onHeld=${()=>a(!0)} /> <button type="button" onClick=${()=>a(!1)}>${o("no")}</button></p>`}
  ${e&&n`<p class="bad">${e}</p>`}
</section>`;function $e(){let{text:t,act:e}=S.value??{},a=s=>{S.value=null,s&&e()};return S.value&&n`<div class="agreement"><${me} text=${t} onAnswer=${a} /></div>`}var pe=()=>F.value.map(t=>n`<${me} key=${t.question} text=${t.text} problem=${M.value} onAnswer=${e=>be(t,e)} />`);var ge=350;function de(){return v.value&&A(v.value)?n`<${ye} key=${v.value} id=${v.value} />`:null}function ye({id:t}){let e=A(t).value,a=R(null),[s,r]=O(!1);I(()=>{a.current.focus();let i=setTimeout(()=>r(!0),ge),h=he=>he.key==="Escape"&&C();return addEventListener("keydown",h),document.documentElement.classList.add("covered"),()=>{clearTimeout(i),removeEventListener("keydown",h),document.documentElement.classList.remove("covered"),setTimeout(oe)}},[]);let l=Y(e),c=P("favorites",t);return n`<div class="shade" onClick=${()=>s&&C()}></div>
    <section ref=${a} class=${s?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${Z(e)}`}><${f} path=${ee(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&_(e.room),te(e)].filter(Boolean).join(" \xB7 ")} <${le} device=${e} /></p></div>
        ${y("act")&&n`<button type="button" class="round" aria-pressed=${String(c)} aria-label=${o("favorite")} onClick=${()=>U("favorites",t,!c)}><${f} path=${c?d.star:d.starOff} /></button>`}
        <button type="button" class="round" aria-label=${o("close|do")} onClick=${C}><${f} path=${d.close} /></button></header>
      <div class="body">
        <${re} device=${e} />
        ${e.may_act&&(l.Main?n`<${l.Main} device=${e} />`:l.act?.(e)&&n`<div class="solo"><${X} device=${e} act=${l.act(e)} /></div>`)}
        <${ue} device=${e} isShort />
        <${ke} device=${e} main=${l.main} />
        ${y("manage")&&n`<details class="part"><summary>${o("Name, room and tags")}</summary><${ce} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${o("Values, history, facts")} <${f} path=${d.right} /></a></p>
        <${ae} at="day" device=${e} />
      </div>
    </section>`}function ke({device:t,main:e}){let[a,s]=O(null),r=m.value.state==="open",l=t.settable.filter(c=>!e.includes(c));return I(()=>{r&&l.length&&G("/discovery/find_devices",{ids:[t.id]}).then(c=>s(c.devices[0]),()=>{})},[t.id,r]),!l.length||!t.may_act?null:n`<details class="part" open=${e.length===0}><summary>${o("More controls")}</summary>${a&&n`<${ie} short=${t} device=${a} without=${e} />`}</details>`}var g=$(!1),xe=T({home:"Home",security:"Security",climate:"Climate"}),fe=T({plan:"Plan",journal:"Journal",system:"System"}),q=({view:t,text:e,above:a,mark:s,name:r=""})=>n`<a href=${`#/${t}`} class=${r} aria-current=${t===a?"page":void 0}><${f} path=${d[t]} size=${26} /><span>${o(e)}</span>${s>0&&n`<b>${s}</b>`}</a>`;function lt({above:t,children:e}){let{state:a,reason:s}=m.value,r=a==="refused",l={security:ne(V.value).length},c=i=>{i.preventDefault(),document.getElementById("content").focus()};return n`<div class="frame" inert=${!!v.value}>
      <a class="skip" href="#content" onClick=${c}>${o("to the content")}</a>
      <nav class="rail" aria-label=${o("views")}>
        ${Object.entries(xe).map(([i,h])=>n`<${q} key=${i} view=${i} text=${h} above=${t} mark=${(l[i]??0)+se(i)} />`)}
        ${Object.entries(fe).map(([i,h])=>n`<${q} key=${i} view=${i} text=${h} above=${t} name="last" />`)}
        <${q} view="more" text="More" above=${t in fe?"more":t} name="others" />
      </nav>
      <div class="page">
        <p role="status" class=${a==="open"?"hidden":"notice"}>${a==="open"?o(w.value===1?"{count} device":"{count} devices",{count:w.value}):r?o("not logged in"):s&&L.value?o("homebot cannot be reached since {time}: perhaps it is restarting.",{time:z({sec:L.value,nanosec:0})}):o(s||"connecting \u2026")}</p>
        ${(r||g.value||p.value)&&n`<${Se} reason=${r?s:p.value} />`}
        ${J.value&&!w.value&&t!=="system"&&n`<p class="notice"><a href="#/setup">${o("No device is there yet: set up your home.")}</a></p>`}
        <${pe} />
        <main id="content" tabindex="-1" class=${a==="open"?"":"old"}>${e}</main>
      </div>
    </div>
    <${de} />
    <div class="told"><${$e} />
      <p role="alert" class=${u.value?`outcome ${u.value.isGood?"good":"bad"}`:"hidden"}>
        ${u.value?.text} ${u.value?.override&&n`<button type="button" onClick=${u.value.override}>${o("Command it all the same?")}</button>`} ${u.value&&!u.value.isGood&&n`<button type="button" onClick=${()=>u.value=null}>${o("close|do")}</button>`}
      </p></div>`}function Se({reason:t}){let e=a=>{a.preventDefault();let s=new FormData(a.target);g.value=!1,B(s.get("token").trim(),s.get("remember")==="on")};return n`<form class="card fields" aria-label=${o("log in")} onSubmit=${e}>
    ${t&&n`<p class="bad">${o(t)}</p>`}
    <p>${o("The code that homebot run prints lets a first screen in.")}</p>
    <p>${o("A token gives this page its rights: yours is the line in owner.token, in the folder of homebot's data. For a tablet make one with:")} <code>homebot token new page --scope read --scope 'act: all' --scope manage</code></p>
    <label><span>${o("Token or code")}</span> <input type="password" name="token" autocomplete="off" required /></label>
    <label class="check"><input type="checkbox" name="remember" /> ${o("keep it in this browser")}</label>
    <p class="buttons"><button class="chief">${o("log in")}</button> ${t&&(b.value||t===j)&&n`<button type="button" onClick=${x}>${o("go on without a token")}</button>`} ${p.value&&n`<button type="button" onClick=${()=>p.value=""}>${o("not now")}</button>`}</p>
  </form>`}var ve="homebot.theme",we={"":"as the system",light:"light|theme",dark:"dark|theme"},E=$(localStorage.getItem(ve)??"");k(()=>{localStorage.setItem(ve,E.value),document.documentElement.dataset.theme=E.value});function ft(){let t=b.value&&m.value.state!=="refused";return n`<section class="card screen" aria-labelledby="screen"><h2 id="screen">${o("This screen")}</h2>
    <label><span>${o("Language")}</span> <select name="language" onChange=${e=>Q(e.target.value)}>${Object.entries(N).map(([e,a])=>n`<option key=${e} value=${e} lang=${e} selected=${e===K.value}>${a}</option>`)}</select></label>
    <label><span>${o("Colors")}</span> <select name="theme" onChange=${e=>E.value=e.target.value}>${Object.entries(we).map(([e,a])=>n`<option key=${e} value=${e} selected=${e===E.value}>${o(a)}</option>`)}</select></label>
    <p class="choices">${t?n`<button type="button" onClick=${x}>${o("log out")}</button>`:n`<button type="button" aria-expanded=${g.value} onClick=${()=>g.value=!g.value}>${o("log in")}</button>`}</p>
  </section>`}export{fe as a,lt as b,ft as c};
