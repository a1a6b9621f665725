import{a}from"./chunk-XUBKKN3V.js";import"./chunk-VNN6TQ54.js";import"./chunk-EQO5KSKI.js";export{a as Mini};
