import"./chunk-I6UU6Z42.js";
