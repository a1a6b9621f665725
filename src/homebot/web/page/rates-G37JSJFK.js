import{a as v}from"./chunk-VWTRI3DK.js";import"./chunk-HJ5TEVRD.js";import{A as s,a as d,aa as h,b as u,i as w,k as g,r as f}from"./chunk-VQMOVCEH.js";var x=2e3,M=300,S=10;function O(){let[o,l]=d([]),m=g.value.state==="open";if(u(()=>{if(!m)return;let t=null,r=async()=>{let n=await f("/rosapi/load").catch(()=>null);if(n){if(t){let b=E(t,n);l(y=>[...y,b].slice(-M))}t=n}};r();let i=setInterval(r,x);return()=>clearInterval(i)},[m]),!o.length)return h`<p class="empty">${s("The first values come in two seconds.")}</p>`;let p=o.map(t=>t.at),c=o[o.length-1],e=Math.min(p[0],c.at-60),a=(t,r,i)=>h`<${v} label=${t} times=${p} from=${e} values=${r.map(([,n])=>o.map(n))} names=${r.map(([n])=>n)} text=${i} />`;return h`
    <div class="columns">
      <section><h2>${s("Messages")}</h2>${a(s("messages a second"),[["",t=>t.rate]],t=>`${t}/s`)}</section>
      <section><h2>${s("Queues and losses")}</h2>${a(s("messages that wait, and lost ones"),[[s("waiting"),t=>t.waiting],[s("lost"),t=>t.lost]])}</section>
      <section><h2>${s("Event loop")}</h2>${a(s("delay of the event loop"),[[s("late by"),t=>t.lag]],t=>`${t} ms`)}</section>
    </div>
    <section>
      <h2>${s("Busiest topics")}</h2>
      <div class="scroll" role="region" tabindex="0" aria-label=${s("Busiest topics")}><table class="numbers">
        <thead><tr><th>${s("Topic")}</th><th>${s("Messages")}/s</th><th>${s("waiting")}</th><th>${s("lost")}</th><th>${s("Slowest handler")}</th></tr></thead>
        <tbody>
          ${c.topics.slice(0,S).map(t=>h`<tr key=${t.topic}>
            <th scope="row">${t.topic}</th><td>${t.rate.toFixed(1)}</td><td>${t.waiting}</td><td>${t.lost}</td>
            <td>${t.slowest>0&&`${(t.slowest*1e3).toFixed(1)} ms, ${t.by.replace(/^\//,"")}`}</td>
          </tr>`)}
        </tbody>
      </table></div>
    </section>`}function E(o,l){let m=Math.max(l.at-o.at,.001),p=new Map(o.topics.map(e=>[e.topic,e.published])),c=l.topics.map(({topic:e,published:a})=>{let t=l.queues.filter(i=>i.topic===e),r=t.reduce((i,n)=>n.slowest>i.slowest?n:i,{slowest:0,node:""});return{topic:e,rate:Math.max(0,a-(p.get(e)??a))/m,waiting:Math.max(0,...t.map(i=>i.waiting)),lost:$(t,"lost"),slowest:r.slowest,by:r.node}});return c.sort((e,a)=>a.rate-e.rate||a.waiting-e.waiting||e.topic.localeCompare(a.topic)),{at:w(),rate:$(c,"rate"),waiting:$(c,"waiting"),lost:$(c,"lost"),lag:l.lag*1e3,topics:c}}var $=(o,l)=>o.reduce((m,p)=>m+p[l],0);export{O as Rates};
