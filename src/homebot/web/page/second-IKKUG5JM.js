import{j as a,k as b,m as c,n as d}from"./chunk-OY47CQNG.js";import"./chunk-V2C5M6K4.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
