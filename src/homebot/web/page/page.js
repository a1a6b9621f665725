import"./chunk-HRZRTT2S.js";
