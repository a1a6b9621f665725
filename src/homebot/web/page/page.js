import"./chunk-7LUV2XNT.js";
