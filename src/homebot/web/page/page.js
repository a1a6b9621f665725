import"./chunk-TUJYBKEK.js";
