import"./chunk-XKXX3NRD.js";
