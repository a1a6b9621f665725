// Collects the pages of features: the folder `page` of each as features/NAME, and what they export in features.js; and
// writes the texts of each language in a module of its own, so that a browser loads one; and parts the code so that the first
// load is one file, which packs better than fifteen, with no icon that it does not show.
import * as mdi from "@mdi/js";
import svgpath from "svgpath";
import { cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { FIELDS, keyOf, written } from "./text_key.js";

const folder = process.env.FEATURES;
const features = readdirSync(folder).filter((name) => existsSync(`${folder}/${name}/page/page.js`)).sort();
rmSync("features", { recursive: true, force: true });
for (const name of features) cpSync(`${folder}/${name}/page`, `features/${name}`, { recursive: true });
const imports = features.map((name) => `import { page as ${name} } from "./features/${name}/page.js";\n`);
writeFileSync("features.js", `${imports.join("")}\nexport const FEATURES = [${features.join(", ")}];\n`);

const [texts, told, reasons] = ["languages.json", "told.json", "reasons.json"].map((name) => JSON.parse(readFileSync(name, "utf8")));
const sources = readdirSync(".", { recursive: true }).filter((name) => name.endsWith(".js") && !/node_modules|^languages|^collect/.test(name) && statSync(name).isFile());
const textOf = (name) => readFileSync(name, "utf8");
const later = new Set(sources.flatMap((name) => [...textOf(name).matchAll(/\bimport\("(.+?)"\)/g)].map(([, path]) => join(dirname(name), path))));

// Texts of which only later views speak are in a file of their own; so is what homebot says and no tile shows, and reasons.
const first = new Set();
const reach = (name) => {
  if (first.has(name) || !existsSync(name)) return;
  first.add(name);
  for (const [, path] of textOf(name).matchAll(/(?:from|import) "(\..+?)"/g)) reach(join(dirname(name), path));
};
reach("page.js");
reach("soon.js");
const saidIn = (names) => names.map(textOf).join("\n");
const [early, lately] = [saidIn([...first]), saidIn(sources.filter((name) => !first.has(name)))];
const isLate = (text) => text in told || text in reasons || (!early.includes(JSON.stringify(text)) && lately.includes(JSON.stringify(text)));

const isForm = (text) => text in reasons && text.includes("{"); // is found by its words, others by their keys
const rows = Object.entries({ ...texts, ...told, ...reasons });
let factor = 33;
while (new Set(rows.map(([text]) => keyOf(text, factor))).size < rows.length) factor += 2;
writeFileSync("text_key.js", readFileSync("text_key.js", "utf8").replace("FACTOR = 0", `FACTOR = ${factor}`));
const signed = (text) => Object.entries(FIELDS).reduce((own, [sign, name]) => own.replaceAll(name, sign), text);
mkdirSync("languages", { recursive: true });
["de", "fr", "es", "nl", "it"].forEach((language, column) => {
  for (const isLater of [false, true]) {
    const own = rows.filter(([text]) => isLate(text) === isLater && !isForm(text)).sort(([one], [other]) => keyOf(one, factor) - keyOf(other, factor));
    const lines = [written(own.map(([text]) => keyOf(text, factor))), ...own.map(([, row]) => row[column])]; // the keys in one line pack best
    const forms = rows.filter(([text]) => isForm(text));
    const ending = isLater ? `export const reasons = ${JSON.stringify(signed([...forms.map(([text]) => text), ...forms.map(([, row]) => row[column])].join("\n")))};\n` : "";
    writeFileSync(`languages/${language}${isLater ? "_late" : ""}.js`, `export const texts = ${JSON.stringify(signed(lines.join("\n")))};\n${ending}`);
  }
});

/** An icon by its steps, to a tenth of 24, which is a fifth of a pixel where it is largest: that packs best. */
const drawn = (path) => svgpath(path).rel().round(1).toString();

/** What is loaded later names what is loaded before it: the page, or these files. */
const BEFORE = { "soon.js": "page", "rare_icons.js": "page", "second.js": "page" };
for (const name of sources) {
  const signs = [...new Set([...textOf(name).matchAll(/\bmdi\.(\w+)/g)].map(([, sign]) => sign))];
  const own = textOf(name)
    .replace(/(?<=>)\s*\n\s*|\s*\n\s*(?=<|\$\{)/g, "") // between tags, where it says nothing
    .replace('import * as mdi from "@mdi/js";', signs.map((sign) => `const ${sign} = "${drawn(mdi[sign])}";`).join("\n"))
    .replaceAll("mdi.mdi", "mdi");
  // So what these have themselves is in no file of its own.
  writeFileSync(name, later.has(name) ? `${own}\nimport "${"../".repeat(name.split("/").length - 1) || "./"}${BEFORE[name] ?? "second"}.js";\n` : own);
}

// Sizes that nothing changes are written where they are used, and colors have short names: that packs better.
const tokens = textOf("tokens.css");
const sizes = [...tokens.matchAll(/^  (--[srt]\d): (.+);\n/gm)];
const letters = [..."abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"];
const names = new Map([...new Set(tokens.match(/--[a-z][\w-]*/g))].map((name) => [name, `--${letters.shift()}`]));
for (const name of readdirSync(".").filter((one) => one.endsWith(".css"))) {
  const own = sizes.reduce((text, [line, size, value]) => text.replace(line, "").replaceAll(`var(${size})`, value), textOf(name));
  writeFileSync(name, own.replace(/--[a-z][\w-]*/g, (one) => names.get(one)));
}
