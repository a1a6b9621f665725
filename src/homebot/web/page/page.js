import"./chunk-6SFSNXB4.js";
