import{a}from"./chunk-MRBN34IG.js";import"./chunk-WRSWFWAX.js";import"./chunk-2T56ZRX5.js";export{a as Mini};
