import{a}from"./chunk-5WXISOZS.js";import"./chunk-727GVXZE.js";import"./chunk-QFSHETYI.js";export{a as Mini};
