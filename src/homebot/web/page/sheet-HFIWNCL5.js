import{a as F,b as B,c as K}from"./chunk-DIBWIBBT.js";import{c as y,d as I}from"./chunk-VXTESCSB.js";import{A as E,Ba as $,Ua as h,Z as O,Za as M,_a as T,a as u,aa as S,b as f,d as k,da as v,ia as o,j as g,ja as n,k as p,m as w,pa as c,ta as _,ua as x,v as r,va as R,wa as C,xa as L,ya as l,za as A}from"./chunk-MOF4PBBB.js";var j=new Set(["video_player","speaker","robotic_vacuum_cleaner","x_lawn_mower","generic_switch"]),z=350;function ne(){return l.value&&v(l.value)?o`<${D} key=${l.value} id=${l.value} />`:null}function D({id:t}){let e=v(t).value,i=k(null),[m,d]=u(!1);f(()=>{i.current.focus();let N=setTimeout(()=>d(!0),z),b=P=>P.key==="Escape"&&$();return addEventListener("keydown",b),document.documentElement.classList.add("covered"),()=>{clearTimeout(N),removeEventListener("keydown",b),document.documentElement.classList.remove("covered"),setTimeout(A)}},[]);let a=x(e),s=O("favorites",t);return o`<div class="shade" onClick=${()=>m&&$()}></div>
    <section ref=${i} class=${m?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${R(e)}`}><${c} path=${C(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&E(e.room),L(e)].filter(Boolean).join(" \xB7 ")} <${T} device=${e} /></p></div>
        ${p("act")&&o`<button type="button" class="round" aria-pressed=${String(s)} aria-label=${r("favorite")} onClick=${()=>S("favorites",t,!s)}><${c} path=${s?n.star:n.starOff} /></button>`}
        <button type="button" class="round" aria-label=${r("close|do")} onClick=${$}><${c} path=${n.close} /></button></header>
      <div class="body">
        <${M} device=${e} />
        ${(y(e)||j.has(e.type))&&o`<${I} of=${t} text=${e.name} isExtra=${!y(e)} />`}
        ${e.may_act&&(a.Main?o`<${a.Main} device=${e} />`:a.act?.(e)&&o`<div class="solo"><${_} device=${e} act=${a.act(e)} /></div>`)}
        ${a.group==="climate"&&o`<${h} at="next" device=${e} />`}
        <${K} device=${e} isShort />
        <${G} device=${e} main=${a.main} />
        ${p("manage")&&o`<details class="part"><summary>${r("Name, room and tags")}</summary><${B} device=${e} /></details>`}
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${r("Values, history, facts")} <${c} path=${n.right} /></a></p>
        <${h} at="day" device=${e} />
      </div>
    </section>`}function G({device:t,main:e}){let[i,m]=u(null),d=g.value.state==="open",a=t.settable.filter(s=>!e.includes(s));return f(()=>{d&&a.length&&w("/discovery/find_devices",{ids:[t.id]}).then(s=>m(s.devices[0]),()=>{})},[t.id,d]),!a.length||!t.may_act?null:o`<details class="part" open=${e.length===0}><summary>${r("More controls")}</summary>${i&&o`<${F} short=${t} device=${i} without=${e} />`}</details>`}export{ne as Sheet};
