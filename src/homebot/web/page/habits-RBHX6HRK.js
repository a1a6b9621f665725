import"./chunk-HJ5TEVRD.js";import{$ as S,A as o,Q as c,V as v,W as _,a as y,aa as e,m as w,s as f,x as k}from"./chunk-VQMOVCEH.js";var T=300;function H({zone:s,onChange:n,Parts:i}){let[p,r]=y(null),a=async()=>{r({proposals:[],isSearching:!0}),r({proposals:[],...await f("/habits/suggest",{},T)})},u=async(t,x)=>{let{success:b,message:C}=await f("/habits/decide",{id:t,accept:x},T);S(C,b),b&&r(g=>({...g,proposals:g.proposals.filter(M=>M.id!==t)})),n()},{proposals:m=[],watched:d=[],isSearching:l,success:$,message:h}=p??{};return e`
    <h2>${o("Your habits")}</h2>
    <p class="choices"><button type="button" disabled=${l} onClick=${a}>${o(l?"searching \u2026":"look for habits")}</button> <small>${o("homebot looks in the history of four weeks for what you do again and again, and watches that for a week before it proposes it.")}</small></p>
    ${h&&e`<p class="bad">${h}</p>`}
    ${$&&!m.length&&e`<p class="empty">${o("There is nothing to propose.")}</p>`}
    ${d.map(t=>e`<p class="quiet" key=${t}>${o("watching: {name}",{name:t})}</p>`)}
    <div class="columns">${m.map(t=>e`<${I} key=${t.id} proposal=${t} zone=${s} decide=${u} Parts=${i} />`)}</div>`}function I({proposal:s,zone:n,decide:i,Parts:p}){let{id:r,removes:a,name:u,when:m,conditions:d,occasions:l,proof:$}=s,h=k.value==="en"||a?$:o("In the week of the trial you did this {done} of {total} times; a routine would be right {low} to {high} % of the time.",{done:s.trial_done,total:s.trial_total,low:Math.round(100*s.precision_low),high:Math.round(100*s.precision_high)});return e`<section>
    <h3>${a?o("remove {name}",{name:a}):e`<bdi>${u}</bdi>`}</h3>
    ${!a&&e`<${p} of=${{when:[m],conditions:d,steps:[s.do]}} />`}
    <p>${h}</p>
    ${l.length>0&&e`<details><summary>${o("each time")}</summary>
      <ol class="log">${[...l].reverse().map(t=>e`<li class="own" key=${c(t.at)}><time>${v(n,t.at)}</time><span class=${c(t.done_at)?"":"bad"}>${P(t)}</span></li>`)}</ol>
    </details>`}
    ${w("manage")&&e`<p class="choices"><button type="button" onClick=${()=>i(r,!0)}>${o(a?"remove":"accept")}</button> <button type="button" onClick=${()=>i(r,!1)}>${o(a?"keep":"reject")}</button></p>`}
  </section>`}function P({at:s,done_at:n}){if(!c(n))return o("you did not");let i=c(n)-c(s);return o(i<0?"you did it {time} before":"you did it {time} later",{time:_(Math.abs(i))})}export{H as Habits};
