import{B as k,W as s,a as u,b as d,m as y,n as h,v as e,z as g}from"./chunk-YCDYLEI5.js";function R({onText:o,onClose:m}){let[$,p]=u([]),[r,c]=u(null);return d(()=>{y("/routines/gallery").then(a=>p(a.routines),()=>{})},[]),s`<section class="card fields" aria-labelledby="gallery"><h2 id="gallery">${e("Ready-made routines")}</h2>
    ${r?s`<${C} routine=${r} onText=${o} onBack=${()=>c(null)} />`:s`<div class="list">${$.map(a=>s`<button key=${a.name} type="button" name=${a.name} onClick=${()=>c(a)}>${e(a.about)}</button>`)}</div>`}
    <p class="buttons"><button type="button" onClick=${m}>${e("not now")}</button></p>
  </section>`}function C({routine:o,onText:m,onBack:$}){let[p,r]=u({}),[c,a]=u("");d(()=>{for(let{key:t,find:l}of o.inputs.filter(n=>n.find))y("/discovery/find_devices",{query:l}).then(({devices:n})=>r(i=>({...i,[t]:n.map(b=>b.name)})),()=>r(n=>({...n,[t]:[]})))},[o.name]);let v=async t=>{t.preventDefault();let l=[...new FormData(t.target)].map(([w,x])=>({key:w,value:x})),{success:n,message:i,text:b}=await h("/routines/gallery",{name:o.name,inputs:l});n?m(b):a(i)},f=o.inputs.find(({key:t,find:l})=>l&&p[t]?.length===0);return s`<form class="fields" onSubmit=${v}><p>${e(o.about)}</p>
    ${o.inputs.map(({key:t,find:l,default:n})=>s`<label key=${t}><span>${k(e(t.replace("_"," ")))}</span>
      ${l?s`<select name=${t} required>${(p[t]??[]).map(i=>s`<option key=${i} value=${`'${i}'`}>${g(i)}</option>`)}</select>`:s`<input name=${t} required defaultValue=${n} />`}</label>`)}
    <p role="alert" class="bad">${c||f&&e("No device of this house fits: {what}",{what:e(f.key.replace("_"," "))})}</p>
    <p class="buttons"><button disabled=${!!f}>${e("next step")}</button> <button type="button" onClick=${$}>${e("back")}</button></p>
  </form>`}export{R as Gallery};
