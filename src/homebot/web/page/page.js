import"./chunk-ISDX2PJM.js";
