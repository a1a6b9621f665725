import{a}from"./chunk-O4223NTC.js";import"./chunk-OY47CQNG.js";import"./chunk-V2C5M6K4.js";export{a as Mini};
