import"./chunk-5SHMMBIC.js";
