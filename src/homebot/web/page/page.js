import"./chunk-W2NWREQT.js";
