import{a}from"./chunk-MU7UI2ET.js";import"./chunk-F25MB5TE.js";import"./chunk-X5YZEDXX.js";export{a as Mini};
