// Runs a bare WebAssembly program under node: node run.mjs PROGRAM.wasm ARGUMENTS. It has a clock, arguments and
// standard output. What else a C library may import answers "not supported" (52).
import { readFileSync } from "node:fs";
import { WASI } from "node:wasi";

const [program, ...rest] = process.argv.slice(2);
const wasi = new WASI({ version: "preview1", args: [program, ...rest], env: {} });
const module = new WebAssembly.Module(readFileSync(program));
const env = {};
for (const { module: from, name } of WebAssembly.Module.imports(module)) if (from === "env") env[name] = () => -52;
wasi.start(new WebAssembly.Instance(module, { env, wasi_snapshot_preview1: wasi.wasiImport }));
