import{a}from"./chunk-XTSK4XXP.js";import"./chunk-C4FMWVYZ.js";import"./chunk-CWGNARWK.js";export{a as Mini};
