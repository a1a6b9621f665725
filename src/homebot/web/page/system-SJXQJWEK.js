import{l as I}from"./chunk-HJ5TEVRD.js";import{A as o,B as h,E as b,G as k,Ha as T,J as A,Q as x,U as S,V as N,a as $,aa as t,b as d,k as y,la as C,m as v,pa as m,r as u,s as g,u as w,y as f}from"./chunk-VQMOVCEH.js";var R={"setup/home":"Name and place","setup/devices":"Devices","setup/rooms":"Rooms","setup/people":"People","setup/alerts":"Alerts","setup/screens":"Screens","setup/backup":"Backup",graph:"Graph",rates:"Rates"},_=5e3,j=50,E=30;function V(){let[e,i]=$(null),[s,c]=$(0),p=y.value.state==="open";return d(()=>{if(!p)return;let n=0,r=!0,a=async()=>{let l=await P();r&&(i(l),n=setTimeout(a,_))};return a(),()=>{r=!1,clearTimeout(n)}},[p,s]),e?t`
    <nav class="choices" aria-label=${o("Set up")}>${Object.entries(R).map(([n,r])=>t`<a key=${n} href=${`#/${n}`}>${o(r)}</a>`)}</nav>
    <${U} devices=${e.waiting} onApproved=${()=>c(s+1)} />
    <section>
      <h2>${o("Doctor")}</h2>
      ${e.findings.every(n=>!n.is_problem)&&t`<p>${o(e.findings.length?"Nothing is wrong. To note:":"Nothing is wrong.")}</p>`}
      <ul class="entries">${e.findings.map(n=>t`<${D} key=${n.code+n.where} finding=${n} />`)}</ul>
    </section>
    <div class="columns">
      ${e.apps&&t`<section>
        <h2>${o("Apps")}</h2>
        ${!e.apps.length&&t`<p class="empty">${o("No app runs.")}</p>`}
        <table class="facts"><tbody>
          ${e.apps.map(n=>t`<tr key=${n.name}><th scope="row">${b(n.name)}</th><td class=${n.state==="running"?"":"bad"}>${o(n.state)}${n.jobs.map(r=>t`<br /><small>${G(r,e.zone)}</small>`)}</td></tr>`)}
        </tbody></table>
      </section>`}
      ${e.gateways.map(n=>t`<section key=${n.name}>
        <h2>${k(h(n.text))}</h2>
        ${n.counts.every(r=>!r.count)&&t`<p class="empty">${o("Nothing is counted yet.")}</p>`}
        <table class="facts"><tbody>
          ${n.counts.filter(r=>r.count).map(r=>t`<tr key=${r.name}><th scope="row">${A(r.name)}</th><td>${r.count.toLocaleString(f.value)}</td></tr>`)}
        </tbody></table>
      </section>`)}
    </div>
    <div class="columns"><${I} /></div>
    <${W} />
    <${O} />`:t`<p class="empty">${o("Asking homebot how it is \u2026")}</p>`}function O(){let[e,i]=$(!1);return d(()=>{fetch("authority.crt",{method:"HEAD"}).then(s=>i(s.status===200),()=>{})},[]),isSecureContext?e&&t`<p class="legend"><a href="authority.crt" download>${o("The certificate that your devices are to trust")}</a></p>`:t`<p class="legend">${o("Without TLS a browser installs no app: set tls = true in [door].")}</p>`}function W(){let[e,i]=$([]);return d(()=>w("/rosout",s=>i(c=>[...s].reverse().concat(c).slice(0,j))),[]),t`<section>
    <h2>${o("Log")}</h2>
    ${!e.length&&t`<p class="empty">${o("Lines appear here as they come.")}</p>`}
    <ol class="log">
      ${e.map((s,c)=>t`<li key=${e.length-c}><time>${S(s.stamp)}</time><span>${s.name}</span><span class=${s.level>=E?"bad":""}>${s.msg}</span></li>`)}
    </ol>
  </section>`}function D({finding:e}){let i=e.total-e.rows.length,s=c=>C(c.what)?t`<a href=${`#/device/${encodeURIComponent(c.what)}`}>${m(c.what)}</a>`:c.what;return t`<li>
    <span class=${e.is_problem?"bad":""}>${e.code} ${e.title&&`${h(e.title)}:`}</span>
    ${e.rows.map((c,p)=>t` ${(c.what||p>0)&&t`<br />`}${s(c)} ${c.why!==m(c.what)&&h(c.why)}`)}
    ${i>0&&t`<br />${o("\u2026 and {count} more",{count:i})}${e.hint}`}
    ${e.next&&t`<br /><small>→ ${o(e.next)}</small>`}
  </li>`}var F=({name:e,text:i})=>e.includes(i)?e:`${e} (${i})`,G=(e,i)=>[F(e),e.note||x(e.next)>0&&`${o("next")} ${N(i,e.next)}`].filter(Boolean).join(", ");async function P(){let e={gateways:[],findings:[]},i=l=>({...e,findings:[{code:"",where:"",title:l.message,is_problem:!0,rows:[],total:0,next:""}]}),s=await u("/rosapi/doctor").catch(i),c=l=>u(`/gateway/${l}/health`).catch(()=>({counts:[]})),p=await Promise.all(s.gateways.map(async l=>({...l,...await c(l.name)}))),n=await u("/control/unapproved").catch(()=>({devices:[],reasons:[]})),{apps:r,zone:a}=await u("/apps/list").catch(()=>({}));return{gateways:p,findings:s.findings.sort((l,L)=>L.is_problem-l.is_problem),waiting:n,apps:r,zone:a}}function U({devices:e,onApproved:i}){let[s,c]=$(null);if(!e.devices.length)return null;let p=new Map(e.reasons.map(a=>[a.key,a.value])),n=async a=>{let l=await g("/discovery/approve",{device:a,is_preview:!0});c({device:a,...l})},r=async()=>{let a=await g("/discovery/approve",{device:s.device,digest:s.digest});c(a.success?null:{device:s.device,...a}),a.success&&i()};return t`<section>
    <h2>${o("Waiting for your approval")}</h2>
    <${T} />
    <ul class="entries">
      ${e.devices.map(a=>t`<li key=${a}>
        <div class="choices">
          <a href=${`#/device/${encodeURIComponent(a)}`}>${m(a)}</a> <span>${h(p.get(a)??"")}</span>
          ${v("manage")&&t`<button type="button" aria-label=${o("show what approving {name} allows",{name:m(a)})} onClick=${()=>n(a)}>${o("show")}</button>`}
        </div>
        ${s?.device===a&&t`<div class="box">
          ${s.message&&t`<p class="bad">${s.message}</p>`}
          ${s.commands?.length>0&&t`<p>${o("Approval allows these commands:")}</p><pre>${s.commands.join(`
`)}</pre>`}
          ${s.changes?.length>0&&t`<p>${o("Changed since the approval before:")}</p><pre>${s.changes.join(`
`)}</pre>`}
          ${s.success&&t`<button type="button" onClick=${r}>${o("approve {name}",{name:m(a)})}</button>`}
        </div>`}
      </li>`)}
    </ul>
  </section>`}export{V as System};
