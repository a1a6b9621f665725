import{j as a,k as b,m as c,n as d}from"./chunk-VNN6TQ54.js";import"./chunk-EQO5KSKI.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
