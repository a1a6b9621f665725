import{j as a,k as b,m as c,n as d}from"./chunk-LYTZ3YUV.js";import"./chunk-OTPBRPD7.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
