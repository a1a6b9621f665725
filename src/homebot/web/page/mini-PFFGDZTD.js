import{a}from"./chunk-JNGYDSJX.js";import"./chunk-LYTZ3YUV.js";import"./chunk-OTPBRPD7.js";export{a as Mini};
