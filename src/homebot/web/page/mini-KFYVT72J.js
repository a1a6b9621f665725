import{a}from"./chunk-T7QPX7A7.js";import"./chunk-HG66Y2JD.js";import"./chunk-6SFSNXB4.js";export{a as Mini};
