import{j as a,k as b,m as c,n as d}from"./chunk-IZXR4LNE.js";import"./chunk-6UZFJIYX.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
