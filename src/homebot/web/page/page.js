import"./chunk-53DDHIS6.js";
