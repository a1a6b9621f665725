import{a}from"./chunk-YKAM57AE.js";import"./chunk-4BB532S5.js";import"./chunk-7H6VFOJG.js";export{a as Mini};
