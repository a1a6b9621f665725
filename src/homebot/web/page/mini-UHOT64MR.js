import{a}from"./chunk-5ZZSWFXH.js";import"./chunk-YGZ6WKY2.js";import"./chunk-W6JLJAU5.js";export{a as Mini};
