import{j as a,k as b,m as c,n as d}from"./chunk-K37E2G4S.js";import"./chunk-WDTZDZKE.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
