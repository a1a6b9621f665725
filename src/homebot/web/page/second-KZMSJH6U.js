import{j as a,k as b,m as c,n as d}from"./chunk-337W6PWQ.js";import"./chunk-TGJ36NZA.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
