import{u as n}from"./chunk-CMGFQJRK.js";import{a as $,c as l,t as o,x as t}from"./chunk-GVOJYK5O.js";import{I as s}from"./chunk-DKKXXYSS.js";function f({entry:e,outcome:d,own:i="",names:c}){let{device:a}=e;return s`<li class=${i?"own":""}>
    <time>${o(e.at)}</time>
    ${!i&&s`<span>${a&&s`<a href=${`#/device/${encodeURIComponent(a)}`}>${n(a)}</a>`}</span>`}
    <span class=${p(e)?"bad":""}>
      ${i&&a&&a!==i&&`${l(c.get(a)??n(a))}: `}${t(e)}${d&&s`: <span class=${p(d)?"bad":"quiet"}>${t(d)}</span>`}
    </span>
  </li>`}var p=e=>$.value.failures.includes(e.results[0]?.outcome)||e.kind==="denied"||e.kind==="judged"&&!e.verdicts[0]?.allowed;export{f as a};
