import{j as a,k as b,m as c,n as d}from"./chunk-727GVXZE.js";import"./chunk-QFSHETYI.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
