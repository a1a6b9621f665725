import{j as a,k as b,m as c,n as d}from"./chunk-U5GOOCFH.js";import"./chunk-H4RATPUX.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
