import{a}from"./chunk-O3HSLDMX.js";import"./chunk-H4BTSBSU.js";import"./chunk-7CFHNP4B.js";export{a as Mini};
