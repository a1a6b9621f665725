import"./chunk-RX4ZIRCR.js";
