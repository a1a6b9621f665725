import{j as a,k as b,m as c,n as d}from"./chunk-L2IMXYVI.js";import"./chunk-RX4ZIRCR.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
