import"./chunk-AHFXYAKF.js";
