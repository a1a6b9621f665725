import{a}from"./chunk-6H3CGHFA.js";import"./chunk-L2IMXYVI.js";import"./chunk-RX4ZIRCR.js";export{a as Mini};
