import"./chunk-ESZDG5QI.js";
