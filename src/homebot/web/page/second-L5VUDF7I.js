import{j as a,k as b,m as c,n as d}from"./chunk-HLIXL3KW.js";import"./chunk-VQ2YKBRJ.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
