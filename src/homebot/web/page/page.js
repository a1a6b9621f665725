import"./chunk-CWGNARWK.js";
