import"./chunk-6UZFJIYX.js";
