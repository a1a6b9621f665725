import"./chunk-MOF4PBBB.js";
