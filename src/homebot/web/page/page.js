import"./chunk-WDTZDZKE.js";
