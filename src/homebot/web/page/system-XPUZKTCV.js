import{B as k,E as x,L as A,P as N,Q as S,Ta as I,Za as L,a as $,b as h,da as C,ha as m,ia as t,j as y,k as f,m as u,n as g,p as w,t as v,v as n,w as d,z as b}from"./chunk-YZREWAEG.js";var _=5e3,R=50,W=30;function Q(){let[e,i]=$(null),[s,c]=$(0),p=y.value.state==="open";return h(()=>{if(!p)return;let a=0,r=!0,o=async()=>{let l=await z();r&&(i(l),a=setTimeout(o,_))};return o(),()=>{r=!1,clearTimeout(a)}},[p,s]),e?t`
    <p class="choices"><a href="#/setup/devices">${n("Set up")}</a> <a href="#/graph">${n("Graph")}</a> <a href="#/rates">${n("Rates")}</a></p>
    <${D} devices=${e.waiting} onApproved=${()=>c(s+1)} />
    <section>
      <h2>${n("Doctor")}</h2>
      ${e.findings.every(a=>!a.is_problem)&&t`<p>${n(e.findings.length?"Nothing is wrong. To note:":"Nothing is wrong.")}</p>`}
      <ul class="entries">${e.findings.map(a=>t`<${F} key=${a.code+a.where} finding=${a} />`)}</ul>
    </section>
    <div class="columns">
      ${e.apps&&t`<section>
        <h2>${n("Apps")}</h2>
        ${!e.apps.length&&t`<p class="empty">${n("No app runs.")}</p>`}
        <table class="facts"><tbody>
          ${e.apps.map(a=>t`<tr key=${a.name}><th scope="row">${b(a.name)}</th><td class=${a.state==="running"?"":"bad"}>${n(a.state)}${a.jobs.map(r=>t`<br /><small>${O(r,e.zone)}</small>`)}</td></tr>`)}
        </tbody></table>
      </section>`}
      ${e.gateways.map(a=>t`<section key=${a.name}>
        <h2>${k(d(a.text))}</h2>
        ${a.counts.every(r=>!r.count)&&t`<p class="empty">${n("Nothing is counted yet.")}</p>`}
        <table class="facts"><tbody>
          ${a.counts.filter(r=>r.count).map(r=>t`<tr key=${r.name}><th scope="row">${x(r.name)}</th><td>${r.count.toLocaleString(v.value)}</td></tr>`)}
        </tbody></table>
      </section>`)}
    </div>
    <div class="columns"><${L} /></div>
    <${E} />
    <${j} />`:t`<p class="empty">${n("Asking homebot how it is \u2026")}</p>`}function j(){let[e,i]=$(!1);return h(()=>{fetch("authority.crt",{method:"HEAD"}).then(s=>i(s.status===200),()=>{})},[]),isSecureContext?e&&t`<p class="legend"><a href="authority.crt" download>${n("The certificate that your devices are to trust")}</a></p>`:t`<p class="legend">${n("Without TLS a browser installs no app: set tls = true in [door].")}</p>`}function E(){let[e,i]=$([]);return h(()=>w("/rosout",s=>i(c=>[...s].reverse().concat(c).slice(0,R))),[]),t`<section>
    <h2>${n("Log")}</h2>
    ${!e.length&&t`<p class="empty">${n("Lines appear here as they come.")}</p>`}
    <ol class="log">
      ${e.map((s,c)=>t`<li key=${e.length-c}><time>${N(s.stamp)}</time><span>${s.name}</span><span class=${s.level>=W?"bad":""}>${s.msg}</span></li>`)}
    </ol>
  </section>`}function F({finding:e}){let i=e.total-e.rows.length,s=c=>C(c.what)?t`<a href=${`#/device/${encodeURIComponent(c.what)}`}>${m(c.what)}</a>`:c.what;return t`<li>
    <span class=${e.is_problem?"bad":""}>${e.code} ${e.title&&`${d(e.title)}:`}</span>
    ${e.rows.map((c,p)=>t` ${(c.what||p>0)&&t`<br />`}${s(c)} ${c.why!==m(c.what)&&c.why}`)}
    ${i>0&&t`<br />${n("\u2026 and {count} more",{count:i})}${e.hint}`}
    ${e.next&&t`<br /><small>→ ${n(e.next)}</small>`}
  </li>`}var G=({name:e,text:i})=>e.includes(i)?e:`${e} (${i})`,O=(e,i)=>[G(e),e.note||A(e.next)>0&&`${n("next")} ${S(i,e.next)}`].filter(Boolean).join(", ");async function z(){let e={gateways:[],findings:[]},i=l=>({...e,findings:[{code:"",where:"",title:l.message,is_problem:!0,rows:[],total:0,next:""}]}),s=await u("/rosapi/doctor").catch(i),c=l=>u(`/gateway/${l}/health`).catch(()=>({counts:[]})),p=await Promise.all(s.gateways.map(async l=>({...l,...await c(l.name)}))),a=await u("/control/unapproved").catch(()=>({devices:[],reasons:[]})),{apps:r,zone:o}=await u("/apps/list").catch(()=>({}));return{gateways:p,findings:s.findings.sort((l,T)=>T.is_problem-l.is_problem),waiting:a,apps:r,zone:o}}function D({devices:e,onApproved:i}){let[s,c]=$(null);if(!e.devices.length)return null;let p=new Map(e.reasons.map(o=>[o.key,o.value])),a=async o=>{let l=await g("/discovery/approve",{device:o,is_preview:!0});c({device:o,...l})},r=async()=>{let o=await g("/discovery/approve",{device:s.device,digest:s.digest});c(o.success?null:{device:s.device,...o}),o.success&&i()};return t`<section>
    <h2>${n("Waiting for your approval")}</h2>
    <${I} />
    <ul class="entries">
      ${e.devices.map(o=>t`<li key=${o}>
        <div class="choices">
          <a href=${`#/device/${encodeURIComponent(o)}`}>${m(o)}</a> <span>${d(p.get(o)??"")}</span>
          ${f("manage")&&t`<button type="button" aria-label=${n("show what approving {name} allows",{name:m(o)})} onClick=${()=>a(o)}>${n("show")}</button>`}
        </div>
        ${s?.device===o&&t`<div class="box">
          ${s.message&&t`<p class="bad">${s.message}</p>`}
          ${s.commands?.length>0&&t`<p>${n("Approval allows these commands:")}</p><pre>${s.commands.join(`
`)}</pre>`}
          ${s.changes?.length>0&&t`<p>${n("Changed since the approval before:")}</p><pre>${s.changes.join(`
`)}</pre>`}
          ${s.success&&t`<button type="button" onClick=${r}>${n("approve {name}",{name:m(o)})}</button>`}
        </div>`}
      </li>`)}
    </ul>
  </section>`}export{Q as System};
