import"./chunk-OTPBRPD7.js";
