import{a}from"./chunk-XGH6JVVT.js";import"./chunk-NEQCICRN.js";import"./chunk-W2NWREQT.js";export{a as Mini};
