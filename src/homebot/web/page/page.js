import"./chunk-ZH47MSR7.js";
