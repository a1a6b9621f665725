import"./chunk-7H6VFOJG.js";
