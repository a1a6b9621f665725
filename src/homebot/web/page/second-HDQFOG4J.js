import{j as a,k as b,m as c,n as d}from"./chunk-YTROSEYS.js";import"./chunk-L3XGGW5U.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
