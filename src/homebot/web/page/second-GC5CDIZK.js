import{j as a,k as b,m as c,n as d}from"./chunk-KBAAWRTQ.js";import"./chunk-QPFOFH6T.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
