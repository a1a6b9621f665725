import{a}from"./chunk-V2FWTD25.js";import"./chunk-DG2PCILQ.js";import"./chunk-7LUV2XNT.js";export{a as Mini};
