import{A as D,Ba as H,I as E,J as F,W as r,a as L,b as C,e as j,ea as P,f as N,fa as z,ga as G,j as R,m as S,o as A,v as u}from"./chunk-5ZLUMIKP.js";var v=j(new Map),B=N(()=>[...v.value.keys()].join(`
`)),I=matchMedia("(max-width: 37rem)"),k=j(I.matches);I.addEventListener("change",()=>k.value=I.matches);function ct(){let[t,o]=L(null),[n,c]=L(null),a=R.value.state==="open";if(C(()=>{a&&S("/discovery/places").then(o,()=>{})},[a]),C(()=>A("/robots/poses",e=>v.value=new Map(v.value).set(e.robot,e)),[]),!t)return r`<p class="empty">${u("Asking homebot for the plan \u2026")}</p>`;let i=t.rooms.filter(e=>e.areas.length);if(!i.length)return r`<p class="empty">${u("No room has a shape yet. Give it corners in the table [places.rooms], or import a map: homebot places import FILE.")}</p>`;let s=[...new Set(i.map(e=>e.floor))],$=n??s[0],m=i.filter(e=>e.floor===$),[{width:M,height:d},w]=[U(m),e=>({...e,x:e.y,y:e.x.map(g=>-g)})],x=k.value&&M>d,p=x?m.map(e=>({...e,areas:e.areas.map(w)})):m,O=x?t.doors.map(w):t.doors,h=U(p),f=k.value?h.width/28:Math.max(h.width,h.height)/72,b=new Set(p.map(e=>e.name)),y=new Map(P.value);return r`<section>
    ${s.length>1&&r`<p class="choices">${s.map(e=>r`<button key=${e} type="button" aria-pressed=${e===$} onClick=${()=>c(e)}>${e||u("Ground")}</button>`)}</p>`}
    <div class="scroll" role="region" tabindex="0" aria-label=${u("plan")}>
      <svg class="plan" viewBox=${`${h.left} ${-h.top} ${h.width} ${h.height}`} font-size=${f} stroke-width=${f/9} role="group" aria-label=${u(p.length===1?"plan with {count} room":"plan with {count} rooms",{count:p.length})}>
        <${J} unit=${f} floor=${s.length<2?null:$} isTurned=${x} />
        ${p.map(e=>r`<${Q} key=${e.name} room=${e} unit=${f} ids=${(y.get(e.name)??[]).filter(g=>!G(g))} isTurned=${x} />`)}
        ${O.filter(e=>e.rooms.some(g=>b.has(g))).map(e=>r`<${X} key=${e.name} door=${e} rooms=${p} unit=${f} />`)}
      </svg>
    </div>
    <p class="legend">${u("A full dot is on, open or occupied.")} <${K} /></p>
  </section>`}function J({unit:t,floor:o,isTurned:n}){let c=[...v.value.values()].filter(a=>a.has_position&&a.counts&&(o===null||a.floor===o));return c.map(a=>r`<g key=${a.robot} class="robot" transform=${`translate(${_([a.x,a.y],n)}) scale(${t})`}>
    <title>${a.robot}</title>
    <circle r="1" />
    <path transform=${`rotate(${-a.yaw*180/Math.PI+(n?90:0)})`} d="M 0.65 0 L -0.35 0.45 L -0.35 -0.45 Z" />
    ${c.length>1&&r`<text y="2.2">${a.robot}</text>`}
  </g>`)}var K=()=>[...v.value.values()].map(t=>`${t.robot}: ${t.counts?t.room||u("outside of all rooms"):u("not known now")}.`).join(" ");function Q({room:t,unit:o,ids:n,isTurned:c}){let[a]=t.areas,i=Math.min(...a.x),s=Math.max(...a.y),$=Math.max(...a.x)-i,m=n.map(l=>z(l)?.value).filter(l=>l&&!B.value.split(`
`).includes(l.name)),M=m.filter(l=>l.position.length),d=m.filter(l=>!l.position.length),w=!k.value||$>9*o,[x,p,O]=w?[3.8,1.8,16]:[3.2,2,2],h=Math.max(1,Math.floor(((s-Math.min(...a.y))/o-x-.6)/p)+1),f=Math.max(1,Math.floor($/o/O)),b=h*f,y=d.slice(0,b<d.length?b-1:b),e=l=>[i+o*1.4+Math.floor(l/h)*$/f,-s+o*(x+p*(l%h))],g=e(y.length);return r`<g>
    <path class=${m.some(V)?"area lit":"area"} fill-rule="evenodd" d=${t.areas.map(tt).join(" ")} />
    <a href=${`#/room/${encodeURIComponent(t.name)}`}><text class="name" font-size=${Math.min(o,$/t.name.length)} x=${i+o*.8} y=${-s+1.6*o}>${D(t.name)}</text></a>
    ${y.map((l,q)=>r`<${T} key=${l.id} device=${l} at=${e(q)} unit=${o} most=${w?$/f/o:0} />`)}
    ${y.length<d.length&&r`<text x=${g[0]-o*.4} y=${g[1]+o*.35}>+${d.length-y.length}</text>`}
    ${M.map(l=>r`<${T} key=${l.id} device=${l} at=${_(l.position,c)} unit=${o} most=${0} />`)}
  </g>`}var V=t=>t.type.includes("light")&&[...t.states.values()].some(o=>o.capability==="on_off"&&o.value===!0);function X({door:t,rooms:o,unit:n}){let[c,a]=[W(t.x),W(t.y)],i=o.some(m=>m.areas.some(M=>M.y.some(d=>Math.abs(d-a)<.1))),[s,$]=i?[t.width/2,0]:[0,t.width/2];return r`<path class="door" stroke-width=${n/4} d=${`M ${c-s} ${-a-$} L ${c+s} ${-a+$}`}><title>${t.name}</title></path>`}function T({device:t,at:[o,n],unit:c,most:a}){let i=E(t),[s]=i.split(" \xB7 "),$=m=>{m.preventDefault(),H(t.id)};return r`<a href=${`#/device/${encodeURIComponent(t.id)}`} onClick=${$} aria-label=${`${t.name}: ${i}`}>
    <circle class=${F(t)?"dot on":"dot"} cx=${o} cy=${n} r=${c*(a?.45:.7)}><title>${`${t.name}: ${i}`}</title></circle>
    ${a>0&&r`<text x=${o+c} y=${n+c*.35}>${Y(t.name,a)} ${Z(t.name+s)<a&&r`<tspan class="quiet">${s}</tspan>`}</text>`}
  </a>`}var Z=t=>t.length*.55+3,Y=(t,o)=>Z(t)<o?t:`${t.slice(0,Math.floor((o-3)/.55))}\u2026`,_=([t,o],n)=>n?[o,t]:[t,-o];function U(t){let o=t.flatMap(i=>i.areas.flatMap(s=>s.x)),n=t.flatMap(i=>i.areas.flatMap(s=>s.y)),c=Math.min(...o)-.5,a=Math.max(...n)+.5;return{left:c,top:a,width:Math.max(...o)+.5-c,height:a-Math.min(...n)+.5}}var tt=t=>`${t.x.map((o,n)=>`${n?"L":"M"} ${o} ${-t.y[n]}`).join(" ")} Z`,W=t=>(Math.min(...t)+Math.max(...t))/2;export{ct as Plan};
