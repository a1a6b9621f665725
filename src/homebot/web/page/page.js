import"./chunk-ZGSK4L4W.js";
