import{a}from"./chunk-D6XUOXHR.js";import"./chunk-PZ5OLYEY.js";import"./chunk-TUJYBKEK.js";export{a as Mini};
