import{j as a,k as b,m as c,n as d}from"./chunk-VM2FNRFA.js";import"./chunk-ULDFPZEM.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
