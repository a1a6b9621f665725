import"./chunk-EFSEGFNT.js";
