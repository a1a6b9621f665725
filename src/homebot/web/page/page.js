import"./chunk-4DKQKQC2.js";
