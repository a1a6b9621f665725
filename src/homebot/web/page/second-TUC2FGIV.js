import{j as a,k as b,m as c,n as d}from"./chunk-F6NR5Q5Z.js";import"./chunk-AWUTLYFY.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
