import{a}from"./chunk-HE5HEEFR.js";import"./chunk-THH6ZF6H.js";import"./chunk-F57GDIJ6.js";export{a as Mini};
