import"./chunk-YCDYLEI5.js";
