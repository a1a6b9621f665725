import{a}from"./chunk-A4Q7RSOA.js";import"./chunk-HJ5TEVRD.js";import"./chunk-VQMOVCEH.js";export{a as Mini};
