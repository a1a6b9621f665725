// Writes the root certificate of the test devices, which is public, as DER to the file that is named.
import { writeFileSync } from "node:fs";
import { TestCert_PAA_NoVID_Cert } from "@matter/protocol";

writeFileSync(process.argv[2], Buffer.from(TestCert_PAA_NoVID_Cert));
