import"./chunk-CULHXJ74.js";
