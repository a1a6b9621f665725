import{a}from"./chunk-LF24YWVL.js";import"./chunk-BY7UW3Y4.js";import"./chunk-HRZRTT2S.js";export{a as Mini};
