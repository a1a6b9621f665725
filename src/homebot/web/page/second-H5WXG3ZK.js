import{j as a,k as b,m as c,n as d}from"./chunk-VFVYAVUN.js";import"./chunk-ZH47MSR7.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
