import{j as a,k as b,m as c,n as d,o as e}from"./chunk-MWN4PZNR.js";import"./chunk-L5TU7CXW.js";export{b as Lights,c as LogIn,d as More,e as Room,a as Sheet};
