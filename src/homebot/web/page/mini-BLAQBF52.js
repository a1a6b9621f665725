import{a}from"./chunk-LZO4USSO.js";import"./chunk-K37E2G4S.js";import"./chunk-WDTZDZKE.js";export{a as Mini};
