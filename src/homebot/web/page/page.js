import"./chunk-AWUTLYFY.js";
