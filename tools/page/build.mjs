// Bundles src/ into dist/: report.js, report.css and the licences of what they contain.
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";

const common = { bundle: true, minify: true, target: "es2020", legalComments: "none", charset: "utf8" };
const outputs = await Promise.all([
  build({ ...common, entryPoints: ["src/main.js"], format: "iife", outfile: "dist/report.js",
          metafile: true }),
  build({ ...common, entryPoints: ["src/style.css"], outfile: "dist/report.css", metafile: true }),
]);

// Every package that the bundles contain must be listed with its licence.
const inputs = outputs.flatMap((output) => Object.keys(output.metafile.inputs));
const packages = new Set(
  inputs.map((path) => path.match(/node_modules\/((?:@[^/]+\/)?[^/]+)/)?.[1]).filter(Boolean));
const licences = [...packages].sort().map((name) => {
  const { version, homepage } = JSON.parse(readFileSync(`node_modules/${name}/package.json`));
  return `${name} ${version}  ${homepage}\n\n${readFileSync(`node_modules/${name}/LICENSE`)}`;
});
writeFileSync("dist/LICENSES", `Software in report.js and report.css, beside tagcal's own:\n\n${licences.join("\n")}`);
