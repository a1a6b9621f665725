import"./chunk-V2C5M6K4.js";
