import{j as a,k as b,m as c,n as d}from"./chunk-FFPR7AMZ.js";import"./chunk-5SHMMBIC.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
