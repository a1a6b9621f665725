import"./chunk-2UOMKVPH.js";
