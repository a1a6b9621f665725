import{j as a,k as b,m as c,n as d}from"./chunk-JYHEIRIE.js";import"./chunk-55XG4TZS.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
