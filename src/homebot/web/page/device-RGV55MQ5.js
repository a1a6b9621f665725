import{a as M,b as E,c as F}from"./chunk-IDMUJUDH.js";import{$a as D,Aa as O,D as k,E as $,L as g,P as u,R as T,Sa as _,Va as A,_a as W,a as f,b as h,da as x,i as y,ia as n,j as b,ja as N,m as v,pa as S,v as s,xa as C,z as w}from"./chunk-4DKQKQC2.js";var K=new Set(["measurement","number","option","state","text","value"]);function mt({id:o}){let t=x(o)?.value,[a,e]=f(null),m=b.value.state==="open",r=t?.changedAt;return h(()=>{if(!m)return;let i=!0,l=setTimeout(async()=>{let p=await v("/discovery/find_devices",{ids:[o]}).catch(()=>null);i&&e(p?.devices[0]??null)},200);return()=>{i=!1,clearTimeout(l)}},[o,m,r]),t?n`
    <div class="title">
      <h1>${t.name} <small>${$(t.type)}${t.room&&`, ${w(t.room)}`}</small></h1>
      <${D} device=${t} />
      <button type="button" class="pill" onClick=${()=>O(o)}>${C(t)} <${S} path=${N.right} /></button>
    </div>
    <${W} device=${t} />
    <div class="pair">
      <div>
        <${U} short=${t} full=${a} />
        ${a&&n`<${q} short=${t} device=${a} />`}
        <section>
          <h2>${s("Name, room and tags")}</h2>
          <${E} device=${t} />
        </section>
      </div>
      <div>
        <${A} key=${o} at="device" device=${t} />
        <${F} device=${t} />
      </div>
    </div>
    ${a&&n`<${z} device=${a} />`}
  `:n`<h1><bdi>${o}</bdi></h1><p class="empty">${s("There is no device {name} (any more).",{name:o})}</p>`}function U({short:o,full:t}){let a=new Map((t?.states??[]).map(r=>[`${r.part} ${r.capability}`,r])),e=[...o.states],m=e.map(([r,i])=>{let l=a.get(r),p=l?u(l.since):"",{unit:j,grid:B=[]}=H(t,i)??{},d=K.has(i.capability)&&V(t,i.part),G=e.filter(([,I])=>I.capability===i.capability).length>1;return n`<tr key=${r}>
      <th scope="row">${G&&!d&&i.part&&`${V(t,i.part)} `}${d||$(i.capability)}</th>
      <td>${k(i.capability,i.value,j,B[1])}</td>
      <td>${p&&n`<time>${s("since {time}",{time:p})}</time>`}</td>
    </tr>`});return n`<section>
    <h2>${s("Values")}</h2>
    <table class="facts">
      <tbody>
        ${m}
      </tbody>
    </table>
  </section>`}function q({short:o,device:t}){return t.parts.some(({part:a})=>!a.category&&a.capabilities.some(e=>e.settable))?n`<section>
    <h2>${s("Commands")}</h2>
    ${o.may_act?n`<${M} short=${o} device=${t} />`:n`<${_} right="act" lacks />`}
  </section>`:null}function z({device:o}){let t=o.facts.filter(e=>e.name==="unreadable"),a=y()-g(o.last_seen);return n`<section>
    <h2>${s("What is known, and from where")}</h2>
    ${t.map(e=>n`<p class="bad" key=${e.key+e.value}>${s("Not understood at {time}:",{time:u(e.said_at)})} ${e.value}</p>`)}
    <table class="facts">
      <tbody>
        ${c("id",o.id)}
        ${c(s("last seen"),s("{time} ago",{time:T(Math.max(a,0))}),s(o.freshness==="unconfirmed"?"last known":o.freshness))}
        ${o.facts.filter(e=>!t.includes(e)).map(e=>c($(e.name),e.value,e.convention==="owner"?s("you, by {what}",{what:e.key}):[e.gateway,e.convention].filter(Boolean).join(", ")))}
        ${o.endpoints.map(e=>c(s("reached by"),`${e.gateway}: ${L(e.address)||e.key}`,L(e.command_address)))}
        ${o.conflicts.map(e=>c(s("conflict"),e))}
      </tbody>
    </table>
  </section>`}var L=o=>o.startsWith("words:")?"":o,c=(o,t,a="")=>n`<tr><th scope="row">${o}</th><td>${t} <small>${a}</small></td></tr>`;function H(o,t){return o?.parts.find(e=>e.id===t.part)?.part.capabilities.find(e=>e.name===t.capability)}var V=(o,t)=>o?.parts.find(a=>a.id===t)?.part.name||t;export{mt as Device};
