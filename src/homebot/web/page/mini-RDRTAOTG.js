import{a}from"./chunk-MDVZQ7TL.js";import"./chunk-VFVYAVUN.js";import"./chunk-ZH47MSR7.js";export{a as Mini};
