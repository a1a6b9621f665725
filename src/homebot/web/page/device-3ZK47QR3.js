import{a as O,b as D,i as F}from"./chunk-HJ5TEVRD.js";import{A as s,E as k,Fa as A,Ga as M,I as g,J as $,Ja as _,Ka as W,Na as E,Q as T,U as u,W as x,a as f,aa as n,b as h,i as y,jb as L,k as b,la as N,m as v,qa as S,r as w,wa as C}from"./chunk-VQMOVCEH.js";var U=new Set(["measurement","number","option","state","text","value"]);function lt({id:o}){let t=N(o)?.value,[a,e]=f(null),m=b.value.state==="open",r=t?.changedAt;return h(()=>{if(!m)return;let i=!0,l=setTimeout(async()=>{let p=await w("/discovery/find_devices",{ids:[o]}).catch(()=>null);i&&e(p?.devices[0]??null)},200);return()=>{i=!1,clearTimeout(l)}},[o,m,r]),t?n`
    <div class="title">
      <h1>${t.name} <small>${$(t.type)}${t.room&&`, ${k(t.room)}`}</small></h1>
      <${W} device=${t} />
      <button type="button" class="pill" onClick=${()=>E(o)}>${A(t)} <${C} path=${S.right} /></button>
    </div>
    <${_} device=${t} />
    <div class="pair">
      <div>
        <${q} short=${t} full=${a} />
        ${a&&n`<${z} short=${t} device=${a} />`}
        <section>
          <h2>${s("Name, room and tags")}</h2>
          <${D} device=${t} />
        </section>
      </div>
      <div>
        <${L} key=${o} at="device" device=${t} />
        <${F} device=${t} />
      </div>
    </div>
    ${a&&n`<${H} device=${a} />`}
  `:n`<h1><bdi>${o}</bdi></h1><p class="empty">${s("There is no device {name} (any more).",{name:o})}</p>`}function q({short:o,full:t}){let a=new Map((t?.states??[]).map(r=>[`${r.part} ${r.capability}`,r])),e=[...o.states],m=e.map(([r,i])=>{let l=a.get(r),p=l?u(l.since):"",{unit:B,grid:G=[]}=J(t,i)??{},d=U.has(i.capability)&&j(t,i.part),I=e.filter(([,K])=>K.capability===i.capability).length>1;return n`<tr key=${r}>
      <th scope="row">${I&&!d&&i.part&&`${j(t,i.part)} `}${d||$(i.capability)}</th>
      <td>${g(i.capability,i.value,B,G[1])}</td>
      <td>${p&&n`<time>${s("since {time}",{time:p})}</time>`}</td>
    </tr>`});return n`<section>
    <h2>${s("Values")}</h2>
    <table class="facts">
      <tbody>
        ${m}
      </tbody>
    </table>
  </section>`}function z({short:o,device:t}){return v("act")?t.parts.some(({part:a})=>!a.category&&a.capabilities.some(e=>e.settable))?n`<section>
    <h2>${s("Commands")}</h2>
    <${O} short=${o} device=${t} />
  </section>`:null:n`<${M} right="act" />`}function H({device:o}){let t=o.facts.filter(e=>e.name==="unreadable"),a=y()-T(o.last_seen);return n`<section>
    <h2>${s("What is known, and from where")}</h2>
    ${t.map(e=>n`<p class="bad" key=${e.key+e.value}>${s("Not understood at {time}:",{time:u(e.said_at)})} ${e.value}</p>`)}
    <table class="facts">
      <tbody>
        ${c("id",o.id)}
        ${c(s("last seen"),s("{time} ago",{time:x(Math.max(a,0))}),s(o.freshness==="unconfirmed"?"last known":o.freshness))}
        ${o.facts.filter(e=>!t.includes(e)).map(e=>c($(e.name),e.value,e.convention==="owner"?s("you, by {what}",{what:e.key}):[e.gateway,e.convention].filter(Boolean).join(", ")))}
        ${o.endpoints.map(e=>c(s("reached by"),`${e.gateway}: ${V(e.address)||e.key}`,V(e.command_address)))}
        ${o.conflicts.map(e=>c(s("conflict"),e))}
      </tbody>
    </table>
  </section>`}var V=o=>o.startsWith("words:")?"":o,c=(o,t,a="")=>n`<tr><th scope="row">${o}</th><td>${t} <small>${a}</small></td></tr>`;function J(o,t){return o?.parts.find(e=>e.id===t.part)?.part.capabilities.find(e=>e.name===t.capability)}var j=(o,t)=>o?.parts.find(a=>a.id===t)?.part.name||t;export{lt as Device};
