import"./chunk-2T56ZRX5.js";
