import"./chunk-HJ5TEVRD.js";import{A as u,F as D,N as E,Na as G,O as P,a as L,aa as l,b as C,e as I,f as N,k as R,ka as z,la as j,ma as B,r as S,t as A}from"./chunk-VQMOVCEH.js";var v=I(new Map),q=N(()=>[...v.value.keys()].join(`
`)),F=matchMedia("(max-width: 37rem)"),k=I(F.matches);F.addEventListener("change",()=>k.value=F.matches);function $t(){let[t,e]=L(null),[s,r]=L(null),a=R.value.state==="open";if(C(()=>{a&&S("/discovery/places").then(e,()=>{})},[a]),C(()=>A("/robots/poses",o=>v.value=new Map(v.value).set(o.robot,o)),[]),!t)return l`<p class="empty">${u("Asking homebot for the plan \u2026")}</p>`;let c=t.rooms.filter(o=>o.areas.length);if(!c.length)return l`<p class="empty">${u("No room has a shape yet. Give it corners in the table [places.rooms], or import a map: homebot places import FILE.")}</p>`;let i=[...new Set(c.map(o=>o.floor))],$=s??i[0],h=c.filter(o=>o.floor===$),[{width:y,height:d},M]=[T(h),o=>({...o,x:o.y,y:o.x.map(n=>-n)})],g=k.value&&y>d,p=g?h.map(o=>({...o,areas:o.areas.map(M)})):h,O=g?t.doors.map(M):t.doors,m=T(p),f=k.value?m.width/28:Math.max(m.width,m.height)/72,w=new Set(p.map(o=>o.name)),x=new Map(z.value),b=o=>(x.get(o.name)??[]).filter(n=>!B(n));return l`<section>
    ${i.length>1&&l`<p class="choices">${i.map(o=>l`<button key=${o} type="button" aria-pressed=${o===$} onClick=${()=>r(o)}>${o||u("Ground")}</button>`)}</p>`}
    <div class="scroll" role="region" tabindex="0" aria-label=${u("plan")}>
      <svg class="plan" viewBox=${`${m.left} ${-m.top} ${m.width} ${m.height}`} font-size=${f} stroke-width=${f/9} role="group" aria-label=${u(p.length===1?"plan with {count} room":"plan with {count} rooms",{count:p.length})}>
        ${p.map(o=>l`<${Q} key=${o.name} room=${o} ids=${b(o)} />`)}
        ${O.filter(o=>o.rooms.some(n=>w.has(n))).map(o=>l`<${Y} key=${o.name} door=${o} rooms=${p} unit=${f} />`)}
        <${J} unit=${f} floor=${i.length<2?null:$} isTurned=${g} />
        ${p.map(o=>l`<${V} key=${o.name} room=${o} unit=${f} ids=${b(o)} isTurned=${g} />`)}
      </svg>
    </div>
    <p class="legend">${u("A full dot is on, open or occupied.")} <${K} /></p>
  </section>`}function J({unit:t,floor:e,isTurned:s}){let r=[...v.value.values()].filter(a=>a.has_position&&a.counts&&(e===null||a.floor===e));return r.map(a=>l`<g key=${a.robot} class="robot" transform=${`translate(${Z([a.x,a.y],s)}) scale(${t})`}>
    <title>${a.robot}</title>
    <circle r="1" />
    <path transform=${`rotate(${-a.yaw*180/Math.PI+(s?90:0)})`} d="M 0.65 0 L -0.35 0.45 L -0.35 -0.45 Z" />
    ${r.length>1&&l`<text y="2.2">${a.robot}</text>`}
  </g>`)}var K=()=>[...v.value.values()].map(t=>`${t.robot}: ${t.counts?t.room||u("outside of all rooms"):u("not known now")}.`).join(" ");function Q({room:t,ids:e}){let s=e.some(r=>X(j(r)?.value));return l`<path class=${s?"area lit":"area"} fill-rule="evenodd" d=${t.areas.map(ot).join(" ")} />`}function V({room:t,unit:e,ids:s,isTurned:r}){let[a]=t.areas,c=Math.min(...a.x),i=Math.max(...a.y),$=Math.max(...a.x)-c,h=s.map(n=>j(n)?.value).filter(n=>n&&!q.value.split(`
`).includes(n.name)),y=h.filter(n=>n.position.length),d=h.filter(n=>!n.position.length),M=!k.value||$>9*e,[g,p,O]=M?[3.8,1.8,16]:[3.2,2,2],m=Math.max(1,Math.floor(((i-Math.min(...a.y))/e-g-.6)/p)+1),f=Math.max(1,Math.floor($/e/O)),w=m*f,x=d.slice(0,w<d.length?w-1:w),b=n=>[c+e*1.4+Math.floor(n/m)*$/f,-i+e*(g+p*(n%m))],o=b(x.length);return l`<g>
    <a href=${`#/room/${encodeURIComponent(t.name)}`}><text class="name" font-size=${Math.min(e,$/t.name.length)} x=${c+e*.8} y=${-i+1.6*e}>${D(t.name)}</text></a>
    ${x.map((n,_)=>l`<${H} key=${n.id} device=${n} at=${b(_)} unit=${e} most=${M?$/f/e:0} />`)}
    ${x.length<d.length&&l`<text x=${o[0]-e*.4} y=${o[1]+e*.35}>+${d.length-x.length}</text>`}
    ${y.map(n=>l`<${H} key=${n.id} device=${n} at=${Z(n.position,r)} unit=${e} most=${0} />`)}
  </g>`}var X=t=>t?.type.includes("light")&&[...t.states.values()].some(e=>e.capability==="on_off"&&e.value===!0);function Y({door:t,rooms:e,unit:s}){let[r,a]=[U(t.x),U(t.y)],c=e.some(h=>h.areas.some(y=>y.y.some(d=>Math.abs(d-a)<.1))),[i,$]=c?[t.width/2,0]:[0,t.width/2];return l`<path class="door" stroke-width=${s/4} d=${`M ${r-i} ${-a-$} L ${r+i} ${-a+$}`}><title>${t.name}</title></path>`}function H({device:t,at:[e,s],unit:r,most:a}){let c=E(t),[i]=c.split(" \xB7 "),$=h=>{h.preventDefault(),G(t.id)};return l`<a href=${`#/device/${encodeURIComponent(t.id)}`} onClick=${$} aria-label=${`${t.name}: ${c}`}>
    <circle class=${P(t)?"dot on":"dot"} cx=${e} cy=${s} r=${r*(a?.45:.7)}><title>${`${t.name}: ${c}`}</title></circle>
    ${a>0&&l`<text x=${e+r} y=${s+r*.35}>${tt(t.name,a)} ${W(t.name+i)<a&&l`<tspan class="quiet">${i}</tspan>`}</text>`}
  </a>`}var W=t=>t.length*.55+3,tt=(t,e)=>W(t)<e?t:`${t.slice(0,Math.floor((e-3)/.55))}\u2026`,Z=([t,e],s)=>s?[e,t]:[t,-e];function T(t){let e=t.flatMap(c=>c.areas.flatMap(i=>i.x)),s=t.flatMap(c=>c.areas.flatMap(i=>i.y)),r=Math.min(...e)-.5,a=Math.max(...s)+.5;return{left:r,top:a,width:Math.max(...e)+.5-r,height:a-Math.min(...s)+.5}}var ot=t=>`${t.x.map((e,s)=>`${s?"L":"M"} ${e} ${-t.y[s]}`).join(" ")} Z`,U=t=>(Math.min(...t)+Math.max(...t))/2;export{$t as Plan};
