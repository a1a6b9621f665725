import{a}from"./chunk-I2N3CIRV.js";import"./chunk-LVGY5QOZ.js";import"./chunk-53DDHIS6.js";export{a as Mini};
