import"./chunk-F57GDIJ6.js";
