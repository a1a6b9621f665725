import{a as j}from"./chunk-VJXBOQRH.js";import{a as P,b as H,c as L,d as B,e as V}from"./chunk-WKP3TZRA.js";import{c as I}from"./chunk-3WFHMPTW.js";import{a as A,h as F,s as W}from"./chunk-T7HJ6HO6.js";import"./chunk-NRB5LE54.js";import"./chunk-DIBDR3YO.js";import{n as D}from"./chunk-E4ZU5TWP.js";import"./chunk-YB32CKE5.js";import{c as _,g as M,h as d,j as C,k,o as E,t as x,v as N}from"./chunk-Q45TKNX5.js";import{D as O,F as r,H as T,I as o,c as $,d as f,l as g,n as w,q as S,v as h}from"./chunk-E5CCYWQY.js";var z=[["1 h",3600],["24 h",86400],["7 d",604800],["30 d",2592e3],["1 y",31536e3]],J=300,Q=60;function K({device:t}){let e=[...t.states.values()].filter(c=>typeof c.value=="number"||typeof c.value=="boolean");e.sort((c,u)=>(u.capability==="power")-(c.capability==="power"));let[s,a]=$(null),[n,m]=$(86400),[i,l]=$(null),p=s??e[0],v=w.value.state==="open";return f(()=>{if(!p||!v)return;let c=g(),u={device:t.id,part:p.part,capability:p.capability,points:J,since:{sec:Math.max(0,Math.floor(c-n)),nanosec:0}};h("/history/read",u).then(y=>l({...y,now:c,period:n,capability:p.capability}),y=>l({message:y.message,series:[]}))},[t.id,p?.part,p?.capability,n,v]),p?o`<section>
    <h2>${r("History")}</h2>
    <div class="choices">
      <select aria-label=${r("value")} onChange=${c=>a(e[c.target.selectedIndex])}>
        ${e.map(c=>o`<option key=${`${c.part} ${c.capability}`}>${d(c.capability)}</option>`)}
      </select>
      ${z.map(([c,u])=>o`<button key=${u} type="button" aria-pressed=${u===n} onClick=${()=>m(u)}>${c}</button>`)}
    </div>
    ${i?o`<${X} answer=${i} />`:o`<p class="empty">…</p>`}
    ${e.some(c=>c.capability.startsWith("energy"))&&o`<${tt} id=${t.id} />`}
  </section>`:null}function X({answer:t}){let e=t.series.find(l=>l.times.length&&(l.values.length||k(l.capability)));if(!e)return o`<p class="empty">${t.message||r("Nothing is kept of that time.")}</p>`;let s=e.values.length?void 0:k(e.capability),[a,n]=s?Z(e):Y(e,t.now),m=C({unit:e.unit,name:e.capability}),i=l=>s?r(s[l?1:0]):`${T(l)} ${m}`.trim();return o`<${j} label=${d(e.capability)} times=${a} values=${[n]} names=${[""]} from=${Math.max(t.now-t.period,Math.min(a[0],t.now-Q))} to=${t.now} most=${m==="%"?100:void 0} isStepped=${!e.width} isFlag=${!!s} text=${i} />`}function Y(t,e){return t.width?[t.times,t.values]:[[...t.times,e],[...t.values,t.values[t.values.length-1]]]}function Z({times:t,ends:e,words:s}){let a=[],n=[];return s.forEach((m,i)=>{a.push(t[i]),n.push(m==="true"?1:0);let l=t[i+1];l!==void 0&&l-e[i]<.001||(a.push(e[i]),n.push(l===void 0?n[n.length-1]:null))}),[a,n]}function tt({id:t}){let[e,s]=$([]);if(f(()=>{h("/history/energy",{device:t}).then(n=>s(n.days),()=>{})},[t]),!e.length)return null;let a=Math.max(...e.map(n=>n.used))||1;return o`<h3>${r("Energy by day")}</h3>
    <table class="facts">
      <tbody>
        ${e.map(n=>o`<tr key=${`${n.day} ${n.part}`}>
            <th scope="row">${n.day}</th>
            <td>${G(n.used)}${n.returned>0&&`, ${r("{energy} returned",{energy:G(n.returned)})}`}</td>
            <td><meter min="0" max=${a} value=${n.used} aria-label=${r("energy of {day}",{day:n.day})}></meter></td>
          </tr>`)}
      </tbody>
    </table>`}var G=t=>`${t.toLocaleString(O.value,{minimumFractionDigits:2,maximumFractionDigits:2})} kWh`;var et=new Set(["measurement","number","option","state","text","value"]);function Ct({id:t}){let e=D(t)?.value,[s,a]=$(null),n=w.value.state==="open",m=e?.changedAt;return f(()=>{if(!n)return;let i=!0,l=setTimeout(async()=>{let p=await h("/discovery/find_devices",{ids:[t]}).catch(()=>null);i&&a(p?.devices[0]??null)},200);return()=>{i=!1,clearTimeout(l)}},[t,n,m]),e?o`
    <div class="title">
      <h1>${e.name} <small>${d(e.type)}${e.room&&`, ${_(e.room)}`}</small></h1>
      <${L} device=${e} />
      <button type="button" class="pill" onClick=${()=>I(t)}>${W(e)} <${F} path=${A.right} /></button>
    </div>
    <${H} device=${e} />
    <div class="pair">
      <div>
        <${at} short=${e} full=${s} />
        ${s&&o`<${nt} short=${e} device=${s} />`}
        <section>
          <h2>${r("Name, room and tags")}</h2>
          <${B} device=${e} />
        </section>
      </div>
      <div>
        <${K} key=${t} device=${e} />
        <${V} device=${e} />
      </div>
    </div>
    ${s&&o`<${st} device=${s} />`}
  `:o`<h1><bdi>${t}</bdi></h1><p class="empty">${r("There is no device {name} (any more).",{name:t})}</p>`}function at({short:t,full:e}){let s=new Map((e?.states??[]).map(m=>[`${m.part} ${m.capability}`,m])),a=[...t.states],n=a.map(([m,i])=>{let l=s.get(m),p=l?x(l.since):"",{unit:v,grid:c=[]}=ot(e,i)??{},u=et.has(i.capability)&&U(e,i.part),y=a.filter(([,q])=>q.capability===i.capability).length>1;return o`<tr key=${m}>
      <th scope="row">${y&&!u&&i.part&&`${U(e,i.part)} `}${u||d(i.capability)}</th>
      <td>${M(i.capability,i.value,v,c[1])}</td>
      <td>${p&&o`<time>${r("since {time}",{time:p})}</time>`}</td>
    </tr>`});return o`<section>
    <h2>${r("Values")}</h2>
    <table class="facts">
      <tbody>
        ${n}
      </tbody>
    </table>
  </section>`}function nt({short:t,device:e}){return!S("act")||!e.parts.some(({part:s})=>!s.category&&s.capabilities.some(a=>a.settable))?null:o`<section>
    <h2>${r("Commands")}</h2>
    <${P} short=${t} device=${e} />
  </section>`}function st({device:t}){let e=t.facts.filter(a=>a.name==="unreadable"),s=g()-E(t.last_seen);return o`<section>
    <h2>${r("What is known, and from where")}</h2>
    ${e.map(a=>o`<p class="bad" key=${a.key+a.value}>${r("Not understood at {time}:",{time:x(a.said_at)})} ${a.value}</p>`)}
    <table class="facts">
      <tbody>
        ${b("id",t.id)}
        ${b(r("last seen"),r("{time} ago",{time:N(Math.max(s,0))}),r(t.freshness==="unconfirmed"?"last known":t.freshness))}
        ${t.facts.filter(a=>!e.includes(a)).map(a=>b(d(a.name),a.value,a.convention==="owner"?r("you, by {what}",{what:a.key}):[a.gateway,a.convention].filter(Boolean).join(", ")))}
        ${t.endpoints.map(a=>b(r("reached by"),`${a.gateway}: ${R(a.address)||a.key}`,R(a.command_address)))}
        ${t.conflicts.map(a=>b(r("conflict"),a))}
      </tbody>
    </table>
  </section>`}var R=t=>t.startsWith("words:")?"":t,b=(t,e,s="")=>o`<tr><th scope="row">${t}</th><td>${e} <small>${s}</small></td></tr>`;function ot(t,e){return t?.parts.find(a=>a.id===e.part)?.part.capabilities.find(a=>a.name===e.capability)}var U=(t,e)=>t?.parts.find(s=>s.id===e)?.part.name||e;export{Ct as Device};
