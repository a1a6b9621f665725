import{j as a,k as b,m as c,n as d}from"./chunk-THH6ZF6H.js";import"./chunk-F57GDIJ6.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
