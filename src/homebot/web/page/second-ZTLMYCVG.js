import{j as a,k as b,m as c,n as d}from"./chunk-PZ5OLYEY.js";import"./chunk-TUJYBKEK.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
