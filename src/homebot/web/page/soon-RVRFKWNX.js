import{j as a,k as b,m as c,n as d,o as e}from"./chunk-HJ5TEVRD.js";import"./chunk-VQMOVCEH.js";export{b as Lights,c as LogIn,d as More,e as Room,a as Sheet};
