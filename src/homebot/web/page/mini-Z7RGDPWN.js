import{a}from"./chunk-ZCRVNTJR.js";import"./chunk-YTROSEYS.js";import"./chunk-L3XGGW5U.js";export{a as Mini};
