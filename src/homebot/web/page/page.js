import"./chunk-ULDFPZEM.js";
