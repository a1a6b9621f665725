import{a}from"./chunk-H7QT3UQ3.js";import"./chunk-JYHEIRIE.js";import"./chunk-55XG4TZS.js";export{a as Mini};
