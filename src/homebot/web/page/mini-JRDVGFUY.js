import{a}from"./chunk-Z673XO3G.js";import"./chunk-VNMX2MDR.js";import"./chunk-AWNBYNRN.js";export{a as Mini};
