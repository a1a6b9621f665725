import{c as h,d as N}from"./chunk-BB5LNE4S.js";import{a as T,b as K,c as P}from"./chunk-N3R7UC2I.js";import{$ as E,$a as I,A as _,Aa as M,Ca as d,Ea as A,Fa as F,Va as v,W as o,_a as B,a as u,b as f,ca as O,d as b,fa as p,j as g,k,ka as n,m as w,qa as c,ua as S,v as i,va as x,wa as L,xa as R,ya as C,za as l}from"./chunk-YCDYLEI5.js";var D=new Set(["video_player","speaker","robotic_vacuum_cleaner","x_lawn_mower","generic_switch"]),G=350;function me(){return l.value&&p(l.value)?o`<${U} key=${l.value} id=${l.value} />`:null}function U({id:t}){let e=p(t).value,r=b(null),[m,$]=u(!1);f(()=>{r.current.focus();let j=setTimeout(()=>$(!0),G),y=z=>z.key==="Escape"&&d();return addEventListener("keydown",y),document.documentElement.classList.add("covered"),()=>{clearTimeout(j),removeEventListener("keydown",y),document.documentElement.classList.remove("covered"),setTimeout(M)}},[]);let a=x(e),s=E("favorites",t);return o`<div class="shade" onClick=${()=>m&&d()}></div>
    <section ref=${r} class=${m?"sheet":"sheet new"} role="dialog" aria-modal="true" aria-labelledby="sheetname" tabindex="-1">
      <header><span class=${`icon ${L(e)}`}><${c} path=${R(e)} size=${28} /></span>
        <div><h2 id="sheetname"><bdi>${e.name}</bdi></h2><p>${[e.room&&_(e.room),C(e)].filter(Boolean).join(" \xB7 ")} <${I} device=${e} /></p></div>
        ${k("act")&&o`<button type="button" class="round" aria-pressed=${String(s)} aria-label=${i("favorite")} onClick=${()=>O("favorites",t,!s)}><${c} path=${s?n.star:n.starOff} /></button>`}
        <button type="button" class="round" aria-label=${i("close|do")} onClick=${d}><${c} path=${n.close} /></button></header>
      <div class="body">
        <${B} device=${e} />
        ${(h(e)||D.has(e.type))&&o`<${N} of=${t} text=${e.name} isExtra=${!h(e)} />`}
        ${e.may_act&&(a.Main?o`<${a.Main} device=${e} />`:a.act?.(e)&&o`<div class="solo"><${S} device=${e} act=${a.act(e)} /></div>`)}
        ${e.settable.length>0&&o`<${A} right="act" lacks=${!e.may_act} />`}
        ${a.group==="climate"&&o`<${v} at="next" device=${e} />`}
        <${P} device=${e} isShort />
        <${V} device=${e} main=${a.main} />
        <details class="part"><summary>${i("Name, room and tags")}</summary><${F}><${K} device=${e} /><//></details>
        <p class="links"><a href=${`#/device/${encodeURIComponent(t)}`}>${i("Values, history, facts")} <${c} path=${n.right} /></a></p>
        <${v} at="day" device=${e} />
      </div>
    </section>`}function V({device:t,main:e}){let[r,m]=u(null),$=g.value.state==="open",a=t.settable.filter(s=>!e.includes(s));return f(()=>{$&&a.length&&w("/discovery/find_devices",{ids:[t.id]}).then(s=>m(s.devices[0]),()=>{})},[t.id,$]),!a.length||!t.may_act?null:o`<details class="part" open=${e.length===0}><summary>${i("More controls")}</summary>${r&&o`<${T} short=${t} device=${r} without=${e} />`}</details>`}export{me as Sheet};
