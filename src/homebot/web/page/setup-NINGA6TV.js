import{Ta as L,a as g,b as y,ba as h,ca as N,e as x,ga as q,ia as n,j as O,l as T,m as A,n as b,q as E,r as C,s as D,u as j,v as a}from"./chunk-YZREWAEG.js";var f={language:"Language",home:"Name and place",devices:"Devices",rooms:"Rooms",screens:"Screens"},M=60,R=60,I={mqtt:"MQTT",homeassistant:"Home Assistant",hue:"Philips Hue",homekit:"HomeKit",matter:"Matter",mdns:"mDNS",ble:"Bluetooth",coap:"CoAP"},G={mqtt:{url:"192.168.1.10",user:"",password:""},homeassistant:{url:"192.168.1.20:8123",token:""},hue:{},homekit:{},matter:{},mdns:{},ble:{},coap:{}},z={homeassistant:"http"},B={url:"Address",user:"User",password:"Password",token:"Token"},w=["password","token"],F=["Kitchen","Living room","Bedroom","Bathroom","Hall","Study","Garden","Garage","Cellar","Terrace"],p=x(null),k=e=>JSON.stringify(e),$=e=>I[e]??e,P=e=>Object.entries(e).map(([i,c])=>({key:i,value:c}));async function S(e,i,c={}){return p.value={message:a("writing \u2026"),lines:[],success:!0,isPending:!0},p.value=await b("/setup/change",{table:e,values:P(i),secrets:P(c)},M),p.value.success}var U=async()=>p.value={...await b("/setup/change",{undo:!0},M),isUndone:!0};function _(){let{message:e,lines:i=[],success:c,isPending:t,isUndone:o}=p.value??{};return n`<div role="status" class=${p.value?"box":"hidden"}>
    ${c&&!t&&n`<p>${a(o?"undone":"This is in homebot.toml now:")}</p>`}
    ${i.length>0&&n`<pre>${i.join(`
`)}</pre>`}
    ${e&&n`<p class=${c?"quiet":"bad"}>${e}</p>`}
    ${c&&!t&&!o&&n`<p class="choices"><button type="button" onClick=${U}>${a("undo|setup")}</button></p>`}
  </div>`}function ce({id:e}){let i=e in f?e:"language",c=Object.keys(f),t=c[c.indexOf(i)+1],o={language:V,home:W,devices:K,rooms:Q,screens:ee}[i];return y(()=>{p.value=null},[i]),n`
    <ol class="steps" aria-label=${a("Setup")}>${c.map((l,u)=>n`<li key=${l}><a href=${`#/setup/${l}`} aria-current=${l===i?"step":void 0}><b>${u+1}</b> <span>${a(f[l])}</span></a></li>`)}</ol>
    <section class="card fields"><h2>${a(f[i])}</h2>
      <${L}><${o} /><${_} /><//>
      <p class="choices">${t?n`<a class="chief" href=${`#/setup/${t}`}>${a("next step")}</a>`:n`<a class="chief" href="#/home">${a("to the house")}</a>`}</p>
    </section>`}var V=()=>n`<p class="choices">${Object.entries(C).map(([e,i])=>n`<button key=${e} type="button" lang=${e} aria-pressed=${e===D.value} onClick=${()=>j(e)}>${i}</button>`)}</p>`;function W(){let[e,i]=g(null),c=async o=>{o.preventDefault();let l=Object.fromEntries(new FormData(o.target)),u={name:k(l.name.trim()),zone:k(l.zone.trim())};for(let m of["latitude","longitude"])l[m]&&(u[m]=Number(l[m]).toFixed(3));await S(["home"],u)},t=()=>navigator.geolocation.getCurrentPosition(({coords:o})=>i(o),o=>p.value={success:!1,message:o.message});return n`<form class="fields" onSubmit=${c}>
    <label><span>${a("Name")}</span> <input name="name" required maxlength="60" defaultValue=${O.value.home} /></label>
    <label><span>${a("Time zone")}</span> <input name="zone" required defaultValue=${Intl.DateTimeFormat().resolvedOptions().timeZone} /></label>
    <label><span>${a("Latitude")}</span> <input name="latitude" type="number" step="any" min="-90" max="90" value=${e?.latitude} /></label>
    <label><span>${a("Longitude")}</span> <input name="longitude" type="number" step="any" min="-180" max="180" value=${e?.longitude} /></label>
    <p class="quiet">${a("The place gives sunrise and sunset; it stays here.")}</p>
    <p class="buttons"><button>${a("save")}</button> ${isSecureContext&&navigator.geolocation&&n`<button type="button" onClick=${t}>${a("where this screen is")}</button>`}</p>
  </form>`}function K(){let[e,i]=g(null),[c,t]=g(""),o=()=>A("/setup/found").then(i,()=>{});if(y(()=>T(o),[]),!e)return n`<p class="empty">${a("Asking homebot how it is \u2026")}</p>`;let l=async(s,d)=>{await S(["gateways",s],{act:String(d)})&&o()},u=()=>{t(""),o()},m=Object.keys(G).filter(s=>!e.gateways.includes(s));return n`
    <p>${a(h.value===1?"{count} device":"{count} devices",{count:h.value})}</p>
    ${e.unused.map(s=>n`<section key=${s.gateway+s.url} class="box">
      <h3>${$(s.gateway)}${s.url&&` \xB7 ${s.url}`}</h3>
      <p>${s.names.join(", ")||a("A server on this computer")}</p>${s.next&&n`<p class="quiet">${s.next}</p>`}
      ${c===s.gateway?n`<${H} name=${s.gateway} url=${s.url} onAdded=${u} />`:n`<p class="choices"><button type="button" onClick=${()=>t(s.gateway)}>${a("use {name}",{name:$(s.gateway)})}</button></p>`}
    </section>`)}
    ${e.gateways.map(s=>n`<label key=${s} class="check"><input type="checkbox" name=${`act-${s}`} checked=${e.acting.includes(s)} onChange=${d=>l(s,d.target.checked)} /> ${a("{name} may command devices",{name:$(s)})}</label>`)}
    <label><span>${a("Add")}</span> <select name="gateway" value=${c} onChange=${s=>t(s.target.value)}><option value="">…</option>${m.map(s=>n`<option key=${s} value=${s}>${$(s)}</option>`)}</select></label>
    ${c&&!e.unused.some(s=>s.gateway===c)&&n`<${H} key=${c} name=${c} onAdded=${u} />`}
    <${Z} can=${e.can_restart} />`}function H({name:e,url:i="",onAdded:c}){let t=Object.entries(G[e]??{});return n`<form class="fields" aria-label=${e} onSubmit=${async l=>{l.preventDefault();let u=new FormData(l.target),m=t.map(([r])=>[r,u.get(r).trim()]).filter(([,r])=>r),s=m.filter(([r])=>!w.includes(r)).map(([r,v])=>[r,k(r==="url"&&!v.includes("://")?`${z[e]??e}://${v}`:v)]),d=m.filter(([r])=>w.includes(r));await S(["gateways",e],{...Object.fromEntries(s),act:String(u.get("act")==="on")},Object.fromEntries(d))&&c()}}>
    ${t.map(([l,u])=>n`<label key=${l}><span>${a(B[l])}</span> <input name=${l} type=${w.includes(l)?"password":"text"} autocomplete="off" placeholder=${u} defaultValue=${l==="url"?i:""} required=${l==="url"} /></label>`)}
    <label class="check"><input type="checkbox" name="act" /> ${a("{name} may command devices",{name:$(e)})}</label>
    <p class="buttons"><button>${a("use {name}",{name:$(e)})}</button></p>
  </form>`}function Z({can:e}){let i=async()=>p.value={...await b("/setup/change",{restart:!0}),lines:[],isUndone:!1,isPending:!0};return n`<p class="quiet">${a("New gateways begin with the next start of homebot.")}</p>
    ${e&&n`<p class="choices"><button type="button" name="again" onClick=${i}>${a("start homebot again")}</button></p>`}`}function J(e,i){let c=e.toLowerCase(),t=F.flatMap(o=>[[a(o),a(o)],[o.split(" ")[0],a(o)]]);return[...i.map(o=>[o,o]),...t].find(([o])=>c.includes(o.toLowerCase()))?.[1]??""}function Q(){let e=N.value.map(([t])=>t).filter(Boolean),i=q.value.filter(t=>!t.room).slice(0,R),c=async t=>{t.preventDefault();let o=[...new FormData(t.target)].filter(([,u])=>u.trim()),l=[];for(let[u,m]of o){let{message:s}=await b("/discovery/place",{device:u,room:m.trim(),is_new:!0});s&&l.push(s)}p.value={success:!l.length,message:l.join("; ")||a("saved"),lines:[],isPending:!0}};return i.length?n`<form class="fields" onSubmit=${c}>
    <datalist id="known-rooms">${[...new Set([...e,...F.map(t=>a(t))])].map(t=>n`<option key=${t} value=${t} />`)}</datalist>
    ${i.map(t=>n`<label key=${t.id}><span>${t.name}</span> <input name=${t.id} list="known-rooms" maxlength="200" defaultValue=${J(t.name,e)} /></label>`)}
    <p class="buttons"><button>${a("save")}</button></p>
  </form>`:n`<p>${a(h.value?"Every device has a room.":"No device is there yet.")}</p>`}var X={look:["read"],act:["read","act: all"],manage:["read","act: all","manage"]},Y={look:"look",act:"look and act",manage:"everything"};function ee(){let[e,i]=g(""),c=async t=>{t.preventDefault();let o=new FormData(t.target),l=await E(o.get("name").trim(),X[o.get("may")]);p.value=l.success?null:l,i(l.token?`${location.origin}/#token=${l.token}`:"")};return n`<p>${a("Each screen has a token of its own, which can be taken away.")}</p>
    <form class="fields" onSubmit=${c}>
      <label><span>${a("Name")}</span> <input name="name" required pattern="[A-Za-z0-9_\\-]+" /></label>
      <label><span>${a("It may")}</span> <select name="may">${Object.entries(Y).map(([t,o])=>n`<option key=${t} value=${t} selected=${t==="act"}>${a(o)}</option>`)}</select></label>
      <p class="buttons"><button>${a("make a token")}</button></p>
    </form>
    ${e&&n`<div class="box"><p>${a("Open this once on the screen; it is shown only now:")}</p><pre>${e}</pre></div>`}`}export{ce as Setup};
