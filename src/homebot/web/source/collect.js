// Collects the pages of features: the folder `page` of each as features/NAME, and what they export in features.js; and
// writes the texts of each language in a module of its own, so that a browser loads one.
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";

const folder = process.env.FEATURES;
const names = readdirSync(folder).filter((name) => existsSync(`${folder}/${name}/page/page.js`)).sort();
rmSync("features", { recursive: true, force: true });
for (const name of names) cpSync(`${folder}/${name}/page`, `features/${name}`, { recursive: true });
const imports = names.map((name) => `import { page as ${name} } from "./features/${name}/page.js";\n`);
writeFileSync("features.js", `${imports.join("")}\nexport const FEATURES = [${names.join(", ")}];\n`);

const [texts, reasons] = ["languages.json", "reasons.json"].map((name) => JSON.parse(readFileSync(name, "utf8")));
mkdirSync("languages", { recursive: true });
["de", "fr", "es", "nl", "it"].forEach((language, column) => {
  const own = Object.fromEntries(Object.entries({ ...texts, ...reasons }).map(([text, row]) => [text, row[column]]));
  writeFileSync(`languages/${language}.js`, `export const texts = ${JSON.stringify(own)};\nexport const reasons = ${JSON.stringify(Object.keys(reasons))};\n`);
});
