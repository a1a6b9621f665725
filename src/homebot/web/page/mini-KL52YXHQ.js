import{a}from"./chunk-XHYKPO62.js";import"./chunk-MM3S3HSK.js";import"./chunk-ZOVRBMRX.js";export{a as Mini};
