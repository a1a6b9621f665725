import{j as a,k as b,m as c,n as d}from"./chunk-BY7UW3Y4.js";import"./chunk-HRZRTT2S.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
