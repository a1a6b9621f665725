import{a as _,b as E,c as F}from"./chunk-DIBWIBBT.js";import{Aa as A,D as T,E as $,L as x,P as u,R as N,Ua as M,Za as W,_a as D,a as f,b as h,da as S,i as y,ia as i,j as b,ja as g,k as v,m as w,pa as C,v as a,xa as O,z as k}from"./chunk-MOF4PBBB.js";var L=new Set(["measurement","number","option","state","text","value"]);function ct({id:o}){let t=S(o)?.value,[s,e]=f(null),m=b.value.state==="open",r=t?.changedAt;return h(()=>{if(!m)return;let n=!0,l=setTimeout(async()=>{let p=await w("/discovery/find_devices",{ids:[o]}).catch(()=>null);n&&e(p?.devices[0]??null)},200);return()=>{n=!1,clearTimeout(l)}},[o,m,r]),t?i`
    <div class="title">
      <h1>${t.name} <small>${$(t.type)}${t.room&&`, ${k(t.room)}`}</small></h1>
      <${D} device=${t} />
      <button type="button" class="pill" onClick=${()=>A(o)}>${O(t)} <${C} path=${g.right} /></button>
    </div>
    <${W} device=${t} />
    <div class="pair">
      <div>
        <${U} short=${t} full=${s} />
        ${s&&i`<${q} short=${t} device=${s} />`}
        <section>
          <h2>${a("Name, room and tags")}</h2>
          <${E} device=${t} />
        </section>
      </div>
      <div>
        <${M} key=${o} at="device" device=${t} />
        <${F} device=${t} />
      </div>
    </div>
    ${s&&i`<${z} device=${s} />`}
  `:i`<h1><bdi>${o}</bdi></h1><p class="empty">${a("There is no device {name} (any more).",{name:o})}</p>`}function U({short:o,full:t}){let s=new Map((t?.states??[]).map(r=>[`${r.part} ${r.capability}`,r])),e=[...o.states],m=e.map(([r,n])=>{let l=s.get(r),p=l?u(l.since):"",{unit:B,grid:G=[]}=H(t,n)??{},d=L.has(n.capability)&&j(t,n.part),I=e.filter(([,K])=>K.capability===n.capability).length>1;return i`<tr key=${r}>
      <th scope="row">${I&&!d&&n.part&&`${j(t,n.part)} `}${d||$(n.capability)}</th>
      <td>${T(n.capability,n.value,B,G[1])}</td>
      <td>${p&&i`<time>${a("since {time}",{time:p})}</time>`}</td>
    </tr>`});return i`<section>
    <h2>${a("Values")}</h2>
    <table class="facts">
      <tbody>
        ${m}
      </tbody>
    </table>
  </section>`}function q({short:o,device:t}){return!v("act")||!t.parts.some(({part:s})=>!s.category&&s.capabilities.some(e=>e.settable))?null:i`<section>
    <h2>${a("Commands")}</h2>
    <${_} short=${o} device=${t} />
  </section>`}function z({device:o}){let t=o.facts.filter(e=>e.name==="unreadable"),s=y()-x(o.last_seen);return i`<section>
    <h2>${a("What is known, and from where")}</h2>
    ${t.map(e=>i`<p class="bad" key=${e.key+e.value}>${a("Not understood at {time}:",{time:u(e.said_at)})} ${e.value}</p>`)}
    <table class="facts">
      <tbody>
        ${c("id",o.id)}
        ${c(a("last seen"),a("{time} ago",{time:N(Math.max(s,0))}),a(o.freshness==="unconfirmed"?"last known":o.freshness))}
        ${o.facts.filter(e=>!t.includes(e)).map(e=>c($(e.name),e.value,e.convention==="owner"?a("you, by {what}",{what:e.key}):[e.gateway,e.convention].filter(Boolean).join(", ")))}
        ${o.endpoints.map(e=>c(a("reached by"),`${e.gateway}: ${V(e.address)||e.key}`,V(e.command_address)))}
        ${o.conflicts.map(e=>c(a("conflict"),e))}
      </tbody>
    </table>
  </section>`}var V=o=>o.startsWith("words:")?"":o,c=(o,t,s="")=>i`<tr><th scope="row">${o}</th><td>${t} <small>${s}</small></td></tr>`;function H(o,t){return o?.parts.find(e=>e.id===t.part)?.part.capabilities.find(e=>e.name===t.capability)}var j=(o,t)=>o?.parts.find(s=>s.id===t)?.part.name||t;export{ct as Device};
