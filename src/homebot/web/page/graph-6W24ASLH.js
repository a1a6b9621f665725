import"./chunk-HJ5TEVRD.js";import{A as $,a as y,aa as d,b as S,k as C,r as M}from"./chunk-VQMOVCEH.js";var w=26,W=1e3,O=230,h=[350,650],T=770,E=36;function H(){let[o,r]=y(null),[e,a]=y(""),n=C.value.state==="open";if(S(()=>{n&&M("/rosapi/endpoints").then(t=>r(t.endpoints),()=>{})},[n]),!o)return d`<p class="empty">${$("Asking homebot for its graph \u2026")}</p>`;let s=o.filter(t=>(t.kind==="publisher"||t.kind==="subscription")&&!t.name.includes("/_")),i=new Set(s.filter(t=>!e||t.node===e||t.name===e).map(t=>t.name)),l=s.filter(t=>i.has(t.name)),u=l.filter(t=>t.kind==="publisher"),b=l.filter(t=>t.kind==="subscription"),m=v([...new Set(u.map(t=>t.node))].sort()),c=v(I([...i],u,m)),g=v(I([...new Set(b.map(t=>t.node))],b.map(({node:t,name:f})=>({node:f,name:t})),c)),x=w*(Math.max(m.size,c.size,g.size)+1),p=(t,f)=>t.get(f)+(x-w*(t.size+1))/2,N=t=>()=>a(t===e?"":t),k=(t,f,R,z)=>d`<text key=${`${z} ${t}`} class=${t===e?"chosen":""} text-anchor=${z} x=${f} y=${R+4} onClick=${N(t)}>${t.length>E?`${t.slice(0,E-1)}\u2026`:t}<title>${t}</title></text>`;return d`<section>
    <p class="choices"><label>${$("Show")} <select value=${e} onChange=${t=>a(t.target.value)}>
      <option value="">${$("all")}</option>
      ${[...new Set(s.flatMap(t=>[t.node,t.name]))].sort().map(t=>d`<option key=${t}>${t}</option>`)}
    </select></label> <small>${$("Nodes on the left publish topics, nodes on the right subscribe to them.")}</small></p>
    <div class="scroll" role="region" tabindex="0" aria-label=${$("graph")}><svg class="graph" viewBox=${`0 0 ${W} ${x}`} role="group" aria-label=${$("{nodes} nodes and {topics} topics",{nodes:m.size+g.size,topics:c.size})}>
      ${u.map(t=>G(t,O+8,p(m,t.node),h[0],p(c,t.name)))}
      ${b.map(t=>G(t,h[1],p(c,t.name),T-8,p(g,t.node)))}
      ${[...c.keys()].map(t=>d`<rect key=${t} x=${h[0]} y=${p(c,t)-11} width=${h[1]-h[0]} height="22" rx="11" />`)}
      ${[...m.keys()].map(t=>k(t,O,p(m,t),"end"))}
      ${[...c.keys()].map(t=>k(t,(h[0]+h[1])/2,p(c,t),"middle"))}
      ${[...g.keys()].map(t=>k(t,T,p(g,t),"start"))}
    </svg></div>
  </section>`}var v=o=>new Map(o.map((r,e)=>[r,w*(e+1)]));function I(o,r,e){let a=s=>{let i=r.filter(l=>l.name===s).map(l=>e.get(l.node));return i.length?i.reduce((l,u)=>l+u,0)/i.length:1/0},n=new Map(o.map(s=>[s,a(s)]));return o.sort((s,i)=>n.get(s)===n.get(i)?s.localeCompare(i):n.get(s)-n.get(i))}function G(o,r,e,a,n){return d`<path key=${`${o.kind} ${o.node} ${o.name}`} d=${`M ${r} ${e} C ${r+60} ${e} ${a-60} ${n} ${a} ${n}`} />`}export{H as Graph};
