import{j as a,k as b,m as c,n as d}from"./chunk-CGAAUS66.js";import"./chunk-XKXX3NRD.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
