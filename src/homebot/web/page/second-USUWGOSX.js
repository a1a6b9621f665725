import{j as a,k as b,m as c,n as d}from"./chunk-NPDF7LNS.js";import"./chunk-2UOMKVPH.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
