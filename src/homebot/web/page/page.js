import"./chunk-HQLDBEBG.js";
