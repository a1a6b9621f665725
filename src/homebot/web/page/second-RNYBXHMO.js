import{j as a,k as b,m as c,n as d}from"./chunk-EX5URSWM.js";import"./chunk-CULHXJ74.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
