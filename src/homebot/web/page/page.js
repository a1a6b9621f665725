import"./chunk-W6JLJAU5.js";
