import{j as a,k as b,m as c,n as d}from"./chunk-WRSWFWAX.js";import"./chunk-2T56ZRX5.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
