import"./chunk-X5YZEDXX.js";
