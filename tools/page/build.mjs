// Bundles src/ into dist/: report.js, report.css and the licences of what they contain.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";

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

// What dist/ was made from and what it is: a test fails if either changed since (sha256sum -c).
const sources = readdirSync("src", { recursive: true }).map((name) => `src/${name}`)
  .filter((name) => /\.(js|css)$/.test(name));
const files = ["build.mjs", "package.json", "package-lock.json", ...sources,
  ...["LICENSES", "report.css", "report.js"].map((name) => `dist/${name}`)].sort();
const sum = (name) => createHash("sha256").update(readFileSync(name)).digest("hex");
writeFileSync("dist/SHA256SUMS", files.map((name) => `${sum(name)}  ${name}\n`).join(""));
