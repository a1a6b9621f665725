import{a}from"./chunk-G5WV2VIJ.js";import"./chunk-EX5URSWM.js";import"./chunk-CULHXJ74.js";export{a as Mini};
