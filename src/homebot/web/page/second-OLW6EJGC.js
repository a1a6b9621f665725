import{j as a,k as b,m as c,n as d}from"./chunk-DG2PCILQ.js";import"./chunk-7LUV2XNT.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
