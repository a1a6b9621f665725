import"./chunk-TGJ36NZA.js";
