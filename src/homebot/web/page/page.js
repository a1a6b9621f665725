import"./chunk-HCVP6RBD.js";
