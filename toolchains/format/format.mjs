// The layout of JavaScript and Python, and what their linters find. The packages lie in build/format.
//   node format.mjs check    fails where a file is laid out otherwise, or a linter finds something
//   node format.mjs write    lays the files out
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

const from = createRequire(new URL("../../build/format/", import.meta.url));
const { ESLint } = from("eslint");
const { Workspace, PositionEncoding } = from("@astral-sh/ruff-wasm-nodejs");
const prettier = from("prettier");
const own = (file) => fileURLToPath(new URL(file, import.meta.url));

process.chdir(own("../.."));
const writes = process.argv[2] === "write";
const files = execFileSync("git", ["ls-files", "*.mjs", "*.mts", "*.d.ts", "*.py"], { encoding: "utf8" })
  .trim()
  .split("\n");
const scripts = files.filter((file) => /\.m[jt]s$/.test(file));
const faults = [];

const settings = JSON.parse(readFileSync(own("prettier.json"), "utf8"));
const ruff = new Workspace(from("smol-toml").parse(readFileSync(own("ruff.toml"), "utf8")), PositionEncoding.Utf16);

async function laidOut(file, text) {
  if (file.endsWith(".py")) return ruff.format(text);
  return prettier.format(text, { ...settings, filepath: file });
}

for (const file of files) {
  const text = readFileSync(file, "utf8");
  const right = await laidOut(file, text);
  if (right === text) continue;
  if (writes) writeFileSync(file, right);
  else faults.push(`${file}: not formatted: node toolchains/format/format.mjs write`);
}

for (const file of files.filter((name) => name.endsWith(".py")))
  for (const { code, message, start_location: at } of ruff.check(readFileSync(file, "utf8")))
    faults.push(`${file}:${at.row}: ${code} ${message}`);

const lint = new ESLint({ overrideConfigFile: own("eslint.config.mjs") });
for (const { filePath, messages } of await lint.lintFiles(scripts))
  for (const { line, ruleId, message } of messages) faults.push(`${filePath}:${line}: ${ruleId} ${message}`);

console.log(faults.length ? faults.join("\n") : `${files.length} files`);
process.exitCode = faults.length ? 1 : 0;
