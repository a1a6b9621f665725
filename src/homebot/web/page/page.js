import"./chunk-ZOVRBMRX.js";
