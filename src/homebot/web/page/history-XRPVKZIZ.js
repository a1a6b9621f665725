import{a as S}from"./chunk-VWTRI3DK.js";import"./chunk-HJ5TEVRD.js";import{A as c,C as k,J as h,L as O,M as b,a as y,aa as o,b as $,i as v,k as w,r as f,y as x}from"./chunk-VQMOVCEH.js";var E=[["1 h",3600],["24 h",86400],["7 d",604800],["30 d",2592e3],["1 y",31536e3]],M=300,D=60;function R({device:t}){let a=[...t.states.values()].filter(n=>typeof n.value=="number"||typeof n.value=="boolean");a.sort((n,p)=>(p.capability==="power")-(n.capability==="power"));let[s,r]=y(null),[e,m]=y(86400),[l,i]=y(null),u=s??a[0],g=w.value.state==="open";return $(()=>{if(!u||!g)return;let n=v(),p={device:t.id,part:u.part,capability:u.capability,points:M,since:{sec:Math.max(0,Math.floor(n-e)),nanosec:0}};f("/history/read",p).then(d=>i({...d,now:n,period:e,capability:u.capability}),d=>i({message:d.message,series:[]}))},[t.id,u?.part,u?.capability,e,g]),u?o`<section>
    <h2>${c("History")}</h2>
    <div class="choices">
      <select aria-label=${c("value")} onChange=${n=>r(a[n.target.selectedIndex])}>
        ${a.map(n=>o`<option key=${`${n.part} ${n.capability}`}>${h(n.capability)}</option>`)}
      </select>
      ${E.map(([n,p])=>o`<button key=${p} type="button" aria-pressed=${p===e} onClick=${()=>m(p)}>${n}</button>`)}
    </div>
    ${l?o`<${P} answer=${l} />`:o`<p class="empty">…</p>`}
    ${a.some(n=>n.capability.startsWith("energy"))&&o`<${F} id=${t.id} />`}
  </section>`:null}function P({answer:t}){let a=t.series.find(i=>i.times.length&&(i.values.length||b(i.capability)));if(!a)return o`<p class="empty">${t.message||c("Nothing is kept of that time.")}</p>`;let s=a.values.length?void 0:b(a.capability),[r,e]=s?C(a):T(a,t.now),m=O({unit:a.unit,name:a.capability}),l=i=>s?c(s[i?1:0]):`${k(i)} ${m}`.trim();return o`<${S} label=${h(a.capability)} times=${r} values=${[e]} names=${[""]} from=${Math.max(t.now-t.period,Math.min(r[0],t.now-D))} to=${t.now} most=${m==="%"?100:void 0} isStepped=${!a.width} isFlag=${!!s} text=${l} />`}function T(t,a){return t.width?[t.times,t.values]:[[...t.times,a],[...t.values,t.values[t.values.length-1]]]}function C({times:t,ends:a,words:s}){let r=[],e=[];return s.forEach((m,l)=>{r.push(t[l]),e.push(m==="true"?1:0);let i=t[l+1];i!==void 0&&i-a[l]<.001||(r.push(a[l]),e.push(i===void 0?e[e.length-1]:null))}),[r,e]}function F({id:t}){let[a,s]=y([]);if($(()=>{f("/history/energy",{device:t}).then(e=>s(e.days),()=>{})},[t]),!a.length)return null;let r=Math.max(...a.map(e=>e.used))||1;return o`<h3>${c("Energy by day")}</h3>
    <table class="facts">
      <tbody>
        ${a.map(e=>o`<tr key=${`${e.day} ${e.part}`}>
            <th scope="row">${e.day}</th>
            <td>${_(e.used)}${e.returned>0&&`, ${c("{energy} returned",{energy:_(e.returned)})}`}</td>
            <td><meter min="0" max=${r} value=${e.used} aria-label=${c("energy of {day}",{day:e.day})}></meter></td>
          </tr>`)}
      </tbody>
    </table>`}var _=t=>`${t.toLocaleString(x.value,{minimumFractionDigits:2,maximumFractionDigits:2})} kWh`;export{R as History};
