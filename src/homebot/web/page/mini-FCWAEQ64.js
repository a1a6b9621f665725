import{a}from"./chunk-7KZKWY6J.js";import"./chunk-VM2FNRFA.js";import"./chunk-ULDFPZEM.js";export{a as Mini};
