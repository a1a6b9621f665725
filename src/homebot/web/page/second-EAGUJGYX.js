import{j as a,k as b,m as c,n as d}from"./chunk-3S5CIPDP.js";import"./chunk-EFSEGFNT.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
