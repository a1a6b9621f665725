import{j as a,k as b,m as c,n as d}from"./chunk-YGZ6WKY2.js";import"./chunk-W6JLJAU5.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
