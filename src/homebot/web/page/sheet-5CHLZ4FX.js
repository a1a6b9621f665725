import{c as h,d as I}from"./chunk-4LUPXUCQ.js";import{a as F,b as B,c as K}from"./chunk-R7KZ5B2L.js";import{A as w,Ba as $,Ua as A,Z as E,Za as M,_a as T,a as u,aa as O,b as f,d as b,da as v,ia as o,j as k,ja as n,k as p,m as g,pa as c,ta as S,ua as _,v as r,va as x,wa as R,xa as C,ya as l,za as L}from"./chunk-AHFXYAKF.js";var j=new Set(["video_player","speaker","robotic_vacuum_cleaner","x_lawn_mower","generic_switch"]),z=350;function ne(){return l.value&&v(l.value)?o`<${D} key=${l.value} id=${l.value} />`:null}function D({id:t}){let e=v(t).value,i=b(null),[m,d]=u(!1);f(()=>{i.current.focus();let N=setTimeout(()=>d(!0),z),y=P=>P.key==="Escape"&&$();return addEventListener("keydown",y),document.documentElement.classList.add("covered"),()=>{clearTimeout(N),removeEventListener("keydown",y),document.documentElement.classList.remove("covered"),setTimeout(L)}},[]);let s=_(e),a=E("favorites",t);return o`<div class="shade" onClick=${()=>m&&$()}></div>
    <section ref=${i} class=${m?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${x(e)}`}><${c} path=${R(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&w(e.room),C(e)].filter(Boolean).join(" \xB7 ")} <${T} device=${e} /></p></div>
        ${p("act")&&o`<button type="button" class="round" aria-pressed=${String(a)} aria-label=${r("favorite")} onClick=${()=>O("favorites",t,!a)}><${c} path=${a?n.star:n.starOff} /></button>`}
        <button type="button" class="round" aria-label=${r("close|do")} onClick=${$}><${c} path=${n.close} /></button></header>
      <div class="body">
        <${M} device=${e} />
        ${(h(e)||j.has(e.type))&&o`<${I} of=${t} text=${e.name} isExtra=${!h(e)} />`}
        ${e.may_act&&(s.Main?o`<${s.Main} device=${e} />`:s.act?.(e)&&o`<div class="solo"><${S} device=${e} act=${s.act(e)} /></div>`)}
        <${K} device=${e} isShort />
        <${G} device=${e} main=${s.main} />
        ${p("manage")&&o`<details class="part"><summary>${r("Name, room and tags")}</summary><${B} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${r("Values, history, facts")} <${c} path=${n.right} /></a></p>
        <${A} at="day" device=${e} />
      </div>
    </section>`}function G({device:t,main:e}){let[i,m]=u(null),d=k.value.state==="open",s=t.settable.filter(a=>!e.includes(a));return f(()=>{d&&s.length&&g("/discovery/find_devices",{ids:[t.id]}).then(a=>m(a.devices[0]),()=>{})},[t.id,d]),!s.length||!t.may_act?null:o`<details class="part" open=${e.length===0}><summary>${r("More controls")}</summary>${i&&o`<${F} short=${t} device=${i} without=${e} />`}</details>`}export{ne as Sheet};
