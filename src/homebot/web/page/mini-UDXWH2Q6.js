import{a}from"./chunk-EAXIE2WL.js";import"./chunk-MWN4PZNR.js";import"./chunk-L5TU7CXW.js";export{a as Mini};
