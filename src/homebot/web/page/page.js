import"./chunk-VQ2YKBRJ.js";
