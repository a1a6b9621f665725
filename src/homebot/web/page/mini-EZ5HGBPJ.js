import{a}from"./chunk-ZYVWR362.js";import"./chunk-CGAAUS66.js";import"./chunk-XKXX3NRD.js";export{a as Mini};
