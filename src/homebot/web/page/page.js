import"./chunk-VQMOVCEH.js";
