import{j as a,k as b,m as c,n as d}from"./chunk-LVGY5QOZ.js";import"./chunk-53DDHIS6.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
