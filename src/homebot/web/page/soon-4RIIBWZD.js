import{j as a,k as b,m as c,n as d,o as e}from"./chunk-H4BTSBSU.js";import"./chunk-7CFHNP4B.js";export{b as Lights,c as LogIn,d as More,e as Room,a as Sheet};
