// Runs a bare WebAssembly program under node: node run.mjs PROGRAM.wasm ARGUMENTS. The program has arguments, a clock,
// standard output and errors, and nothing else: every other call to the system answers "not supported".
import { readFileSync, writeSync } from "node:fs";

const [program, ...rest] = process.argv.slice(2);
const k_good = 0;
const k_not_supported = 58;
const texts = [program, ...rest].map((text) => Buffer.from(`${text}\0`));
let memory;
const put = (at, value) => new DataView(memory.buffer).setUint32(at, value, true);
const get = (at) => new DataView(memory.buffer).getUint32(at, true);
const host = {
  args_sizes_get(count, bytes) {
    put(count, texts.length);
    put(bytes, Buffer.concat(texts).length);
    return k_good;
  },
  args_get(pointers, at) {
    for (const text of texts) {
      put(pointers, at);
      new Uint8Array(memory.buffer).set(text, at);
      pointers += 4;
      at += text.length;
    }
    return k_good;
  },
  environ_sizes_get(count, bytes) {
    put(count, 0);
    put(bytes, 0);
    return k_good;
  },
  environ_get() {
    return k_good;
  },
  clock_time_get(_clock, _precision, at) {
    new DataView(memory.buffer).setBigUint64(at, process.hrtime.bigint(), true);
    return k_good;
  },
  fd_write(file, pieces, count, written) {
    let sum = 0;
    for (let i = 0; i < count; ++i)
      sum += writeSync(file, new Uint8Array(memory.buffer, get(pieces + 8 * i), get(pieces + 8 * i + 4)));
    put(written, sum);
    return k_good;
  },
  fd_close() {
    return k_good;
  },
  proc_exit(code) {
    process.exit(code);
  },
};
const module = new WebAssembly.Module(readFileSync(program));
const imports = { env: {}, wasi_snapshot_preview1: {} };
for (const { module: from, name } of WebAssembly.Module.imports(module))
  imports[from][name] =
    (from === "env" ? undefined : host[name]) ?? (() => (from === "env" ? -k_not_supported : k_not_supported));
const { exports } = new WebAssembly.Instance(module, imports);
memory = exports.memory;
exports._start();
