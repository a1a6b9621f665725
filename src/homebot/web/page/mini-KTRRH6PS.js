import{a}from"./chunk-BQQRUJ6W.js";import"./chunk-NPDF7LNS.js";import"./chunk-2UOMKVPH.js";export{a as Mini};
