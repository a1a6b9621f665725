import"./chunk-5ZLUMIKP.js";
