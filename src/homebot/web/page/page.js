import"./chunk-M3XDOTV3.js";
