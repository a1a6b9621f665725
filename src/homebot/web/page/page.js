import"./chunk-L3XGGW5U.js";
