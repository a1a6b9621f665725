import{j as a,k as b,m as c,n as d,o as e}from"./chunk-VNMX2MDR.js";import"./chunk-AWNBYNRN.js";export{b as Lights,c as LogIn,d as More,e as Room,a as Sheet};
