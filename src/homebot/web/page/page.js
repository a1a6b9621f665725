import"./chunk-AWNBYNRN.js";
