import"./chunk-QB27CDWH.js";
