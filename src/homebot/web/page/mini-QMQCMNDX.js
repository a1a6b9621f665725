import{a}from"./chunk-WAOAI2KR.js";import"./chunk-KBAAWRTQ.js";import"./chunk-QPFOFH6T.js";export{a as Mini};
