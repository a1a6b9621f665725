import{j as a,k as b,m as c,n as d,o as e}from"./chunk-KPKUMXC6.js";import"./chunk-HCVP6RBD.js";export{b as Lights,c as LogIn,d as More,e as Room,a as Sheet};
