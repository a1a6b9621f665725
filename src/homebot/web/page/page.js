import"./chunk-XMAA5WJE.js";
