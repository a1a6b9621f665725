import{j as a,k as b,m as c,n as d}from"./chunk-HG66Y2JD.js";import"./chunk-6SFSNXB4.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
