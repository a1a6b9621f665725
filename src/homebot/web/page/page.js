import"./chunk-L5TU7CXW.js";
