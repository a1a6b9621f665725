import{j as a,k as b,m as c,n as d}from"./chunk-NEQCICRN.js";import"./chunk-W2NWREQT.js";export{b as Lately,c as LogIn,d as More,a as Sheet};
