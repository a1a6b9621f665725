import"./chunk-7CFHNP4B.js";
