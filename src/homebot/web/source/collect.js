// Collects the pages of features: the folder `page` of each as features/NAME, and what they export in features.js.
import { cpSync, existsSync, readdirSync, rmSync, writeFileSync } from "node:fs";

const folder = process.env.FEATURES;
const names = readdirSync(folder).filter((name) => existsSync(`${folder}/${name}/page/page.js`)).sort();
rmSync("features", { recursive: true, force: true });
for (const name of names) cpSync(`${folder}/${name}/page`, `features/${name}`, { recursive: true });
const imports = names.map((name) => `import { page as ${name} } from "./features/${name}/page.js";\n`);
writeFileSync("features.js", `${imports.join("")}\nexport const FEATURES = [${names.join(", ")}];\n`);
