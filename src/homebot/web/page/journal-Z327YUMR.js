import{g as S,h as d}from"./chunk-HJ5TEVRD.js";import{A as n,P as v,a as o,aa as r,b,k as g,pa as w,r as k,u as y}from"./chunk-VQMOVCEH.js";var u=1e3,M=300,B=new Set(["requested","outcome","reverted","changed","published","denied","held","released","ended","expired","outranked"]);function A(){let[t,s]=o([]),[E,L]=o(!1),[c,O]=o(!1),[a,I]=o(""),p=g.value.state==="open";b(()=>{if(!p)return;let e=[],l=!0,N=y("/control/journal_entries",m=>{let $=x(m);l?e.unshift(...$):s(W=>[...$,...W].slice(0,u))});return k("/control/journal",{limit:u}).then(m=>{l=!1,s([...e,...x(m.entries)].slice(0,u)),e=[],L(!0)},()=>l=!1),N},[p]);let T=new Set(t.filter(e=>e.kind==="requested").map(e=>e.command)),j=new Map(t.filter(e=>e.kind==="outcome").map(e=>[e.command,e])),i=c?t:t.filter(e=>B.has(e.kind)&&!(e.kind==="outcome"&&T.has(e.command))),h=e=>!c&&e.kind==="requested"?j.get(e.command):void 0,q=e=>[w(e.device),e.device,d(e),...[h(e)].filter(Boolean).map(d)].join(" "),f=(a.trim()?i.filter(e=>v(q(e),a)):i).slice(0,M);return r`<section>
    <p class="choices">
      <label>${n("Search")} <input type="search" value=${a} onInput=${e=>I(e.target.value)} /></label>
      <label><input type="checkbox" checked=${c} onChange=${e=>O(e.target.checked)} /> ${n("every step")}</label>
    </p>
    ${E&&f.length===0&&r`<p class="empty">${i.length?n("None of the newest {count} entries has these words.",{count:t.length}):n("Nothing has happened yet.")}</p>`}
    <ol class="log" aria-label=${n("newest first")}>
      ${f.map(e=>r`<${S} key=${e.number} entry=${e} outcome=${h(e)} />`)}
    </ol>
  </section>`}var C=0,x=t=>t.map(s=>({...s,number:++C})).reverse();export{A as Journal};
