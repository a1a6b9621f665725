import{j as a,k as b,m as c,n as d}from"./chunk-MM3S3HSK.js";import"./chunk-ZOVRBMRX.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
