import"./chunk-H4RATPUX.js";
