import"./chunk-EQO5KSKI.js";
