import{j as a,k as b,m as c,n as d}from"./chunk-F25MB5TE.js";import"./chunk-X5YZEDXX.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
