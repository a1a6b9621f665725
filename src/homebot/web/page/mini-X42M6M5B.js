import{a}from"./chunk-47VJFWXO.js";import"./chunk-U5GOOCFH.js";import"./chunk-H4RATPUX.js";export{a as Mini};
