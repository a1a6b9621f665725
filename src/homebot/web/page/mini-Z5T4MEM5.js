import{a}from"./chunk-3J32G2DF.js";import"./chunk-IZXR4LNE.js";import"./chunk-6UZFJIYX.js";export{a as Mini};
