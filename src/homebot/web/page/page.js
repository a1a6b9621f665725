import"./chunk-YZREWAEG.js";
