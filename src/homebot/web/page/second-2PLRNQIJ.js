import{j as a,k as b,m as c,n as d}from"./chunk-4BB532S5.js";import"./chunk-7H6VFOJG.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
