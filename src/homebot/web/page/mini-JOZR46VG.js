import{a}from"./chunk-QIS7LUED.js";import"./chunk-F6NR5Q5Z.js";import"./chunk-AWUTLYFY.js";export{a as Mini};
