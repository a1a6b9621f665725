import{a}from"./chunk-3PEDQFA5.js";import"./chunk-FFPR7AMZ.js";import"./chunk-5SHMMBIC.js";export{a as Mini};
