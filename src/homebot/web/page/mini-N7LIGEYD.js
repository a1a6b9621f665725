import{a}from"./chunk-WDSWJCKG.js";import"./chunk-KPKUMXC6.js";import"./chunk-HCVP6RBD.js";export{a as Mini};
