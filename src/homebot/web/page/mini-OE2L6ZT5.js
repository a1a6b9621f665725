import{a}from"./chunk-62P7EUUR.js";import"./chunk-3S5CIPDP.js";import"./chunk-EFSEGFNT.js";export{a as Mini};
