import{a}from"./chunk-WBDUS4VM.js";import"./chunk-337W6PWQ.js";import"./chunk-TGJ36NZA.js";export{a as Mini};
