import{j as a,k as b,m as c,n as d}from"./chunk-C4FMWVYZ.js";import"./chunk-CWGNARWK.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
