import"./chunk-QFSHETYI.js";
