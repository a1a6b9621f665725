import{a}from"./chunk-3GI5UEE3.js";import"./chunk-HLIXL3KW.js";import"./chunk-VQ2YKBRJ.js";export{a as Mini};
