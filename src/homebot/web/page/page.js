import"./chunk-QPFOFH6T.js";
