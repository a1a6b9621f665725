import"./chunk-55XG4TZS.js";
