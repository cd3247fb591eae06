// The C API of Sandglass for JavaScript. Every function of the headers is a method of what load() returns, under its C
// name; every struct is a view of the module's memory with the C fields; constants are exported by their C names.
//
//     const sand = await load();
//     const desc = sand.make("sandglass_scene_desc");
//     sand.sandglass_scene_desc_default(desc);
//     desc.granular.particle_capacity = 1500;
//     const scene = sand.create("sandglass_scene", desc);
//
// A function that takes `reason` in C throws it here as the message of an Error. `const char*` comes back as a string,
// a 64-bit result as a bigint, a 64-bit field as a number. Memory is the module's, and typed arrays of it end when it
// grows: ask for new ones (floats, bytes, view) in every frame. Structs and their array fields outlive growth. Importing
// this file does nothing, so a server may.
import { structs, functions, constants } from "./abi.mjs";

export { constants };

const k_block_alignment = constants.SANDGLASS_BLOCK_ALIGNMENT;
const k_address_space = 2 ** 32; // bytes
const k_least_step_ns = 1000n; // from one reading of the clock to the next
const k_shared_pages = 256; // of 64 KiB, as sandglass-threads.wasm is linked
const k_shared_pages_at_most = 8192;
const k_worker_stack = 65536; // a task needs less than 16 KiB
const k_arrays = {
  u8: Uint8Array,
  i8: Int8Array,
  u16: Uint16Array,
  i16: Int16Array,
  u32: Uint32Array,
  i32: Int32Array,
  ptr: Uint32Array,
  u64: BigUint64Array,
  i64: BigInt64Array,
  f32: Float32Array,
  f64: Float64Array,
};
const k_read = {
  u8: (view, at) => view.getUint8(at),
  i8: (view, at) => view.getInt8(at),
  u16: (view, at) => view.getUint16(at, true),
  i16: (view, at) => view.getInt16(at, true),
  u32: (view, at) => view.getUint32(at, true),
  i32: (view, at) => view.getInt32(at, true),
  ptr: (view, at) => view.getUint32(at, true),
  f32: (view, at) => view.getFloat32(at, true),
  f64: (view, at) => view.getFloat64(at, true),
  u64: (view, at) => Number(view.getBigUint64(at, true)),
  i64: (view, at) => Number(view.getBigInt64(at, true)),
};
const k_write = {
  u8: (view, at, to) => view.setUint8(at, to),
  i8: (view, at, to) => view.setInt8(at, to),
  u16: (view, at, to) => view.setUint16(at, to, true),
  i16: (view, at, to) => view.setInt16(at, to, true),
  u32: (view, at, to) => view.setUint32(at, to, true),
  i32: (view, at, to) => view.setInt32(at, to, true),
  ptr: (view, at, to) => view.setUint32(at, address(to), true),
  f32: (view, at, to) => view.setFloat32(at, to, true),
  f64: (view, at, to) => view.setFloat64(at, to, true),
  u64: (view, at, to) => view.setBigUint64(at, BigInt(to), true),
  i64: (view, at, to) => view.setBigInt64(at, BigInt(to), true),
};

const address = (value) =>
  value === null || value === undefined ? 0 : typeof value === "object" ? value.address : value;

// A class for the array fields of one type and length. Every access goes to the module's memory as it is then.
function arrayClass(type, count, memory, view) {
  const Typed = k_arrays[type];
  const size = Typed.BYTES_PER_ELEMENT;
  class Numbers {
    constructor(at) {
      Object.defineProperty(this, "address", { value: at });
      Object.preventExtensions(this);
    } // no index beyond the last
    get length() {
      return count;
    }
    slice(begin, end) {
      return new Typed(memory.buffer, this.address, count).slice(begin, end);
    }
    set(values, first = 0) {
      Array.from(values).forEach((value, i) => {
        this[first + i] = value;
      });
    }
    fill(value) {
      this.set(Array(count).fill(value));
      return this;
    }
    *[Symbol.iterator]() {
      for (let i = 0; i < count; ++i) yield this[i];
    }
  }
  for (let i = 0; i < count; ++i)
    Object.defineProperty(Numbers.prototype, i, {
      enumerable: true,
      get() {
        return k_read[type](view(), this.address + i * size);
      },
      set(value) {
        k_write[type](view(), this.address + i * size, value);
      },
    });
  return Numbers;
}

// A class for each struct: its fields are properties that read and write the module's memory.
function structClass(name, memory, view, classes) {
  const { size, fields } = structs[name];
  class View {
    constructor(at) {
      this.address = at;
    }
    // Copies another struct of this type, or fields by name.
    set(values) {
      if (values instanceof View)
        new Uint8Array(memory.buffer).copyWithin(this.address, values.address, values.address + size);
      else
        for (const [field, value] of Object.entries(values)) {
          if (!(field in this)) throw new Error(`${name} has no field ${field}`);
          this[field] = value;
        }
      return this;
    }
  }
  for (const [field, type, offset, count] of fields) {
    const inner = type in structs ? structs[type].size : 0;
    const Numbers = count && !inner ? arrayClass(type, count, memory, view) : null;
    Object.defineProperty(View.prototype, field, {
      enumerable: true,
      get() {
        const at = this.address + offset;
        if (inner && count) return Array.from({ length: count }, (_, i) => new classes[type](at + i * inner));
        if (inner) return new classes[type](at);
        if (count) return new Numbers(at);
        return k_read[type](view(), at);
      },
      set(value) {
        const at = this.address + offset;
        if (inner && !count) new classes[type](at).set(value);
        else if (count && !inner) new Numbers(at).set(value);
        else if (!count) k_write[type](view(), at, value);
        else throw new Error(`${name}.${field} is set item by item`);
      },
    });
  }
  return View;
}

// A WebAssembly function that calls `f`, because only such functions can stand in the table of function pointers.
// `signature` is the result, then the parameters: "v" none, "i" 32 bits or a pointer, "j" 64 bits, "f", "d".
function trampoline(f, signature) {
  const code = { i: 0x7f, j: 0x7e, f: 0x7d, d: 0x7c };
  const parameters = [...signature.slice(1)].map((kind) => code[kind]);
  const results = signature[0] === "v" ? [] : [code[signature[0]]];
  const type = [1, 0x60, parameters.length, ...parameters, results.length, ...results];
  const bytes = [
    0,
    0x61,
    0x73,
    0x6d,
    1,
    0,
    0,
    0,
    1,
    type.length,
    ...type,
    2,
    7,
    1,
    1,
    0x65,
    1,
    0x66,
    0,
    0,
    7,
    5,
    1,
    1,
    0x66,
    0,
    0,
  ];
  return new WebAssembly.Instance(new WebAssembly.Module(new Uint8Array(bytes)), { e: { f } }).exports.f;
}

// Bundlers must leave an import of node's own modules as it is.
const fromNode = (name) => import(/* webpackIgnore: true */ /* @vite-ignore */ `node:${name}`);

// The module of a URL, bytes or a module; without one, the file beside this one.
export async function compile(source, threads = 1) {
  source ??=
    threads > 1 ? new URL("./sandglass-threads.wasm", import.meta.url) : new URL("./sandglass.wasm", import.meta.url);
  if (source instanceof WebAssembly.Module) return source;
  if (ArrayBuffer.isView(source) || source instanceof ArrayBuffer) return WebAssembly.compile(source);
  const url = source instanceof URL ? source : new URL(source, globalThis.location?.href ?? import.meta.url);
  if (url.protocol === "file:" && typeof process !== "undefined")
    return WebAssembly.compile(await (await fromNode("fs/promises")).readFile(url));
  const answer = await fetch(url).catch(() => null);
  const bytes = new Uint8Array((await answer?.arrayBuffer()) ?? 0);
  if (answer?.ok && String(bytes.subarray(0, 4)) === "0,97,115,109") return WebAssembly.compile(bytes);
  throw new Error(
    `sandglass: cannot load "${url}": ${!answer ? "there is no answer" : answer.ok ? "the answer is no WebAssembly" : `the server answers ${answer.status}`}. ` +
      'For Vite before 8, write optimizeDeps: { exclude: ["sandglass"] } into vite.config.js; for others, copy sandglass.wasm there or import "sandglass/inline".',
  );
}

// What a worker of the pool runs: a further instance of the module on the shared memory. In a browser and under node.
const k_worker = `
const port = typeof require === "function" ? require("node:worker_threads").parentPort : self;
const heard = (event) => {
  const { module, memory, stack } = event.data ?? event;
  const none = () => 0;
  WebAssembly.instantiate(module, { wasi_snapshot_preview1: { clock_time_get: none, proc_exit: none },
    env: { memory, emscripten_notify_memory_growth: none } }).then(({ exports }) => {
    exports.stackRestore(stack);
    port.postMessage("ready");
    exports.sandglass_web_pool_work();
  });
};
if (port.once) port.once("message", heard); else port.onmessage = heard;`;

async function newWorker() {
  if (typeof Worker === "undefined") {
    const worker = new (await fromNode("worker_threads")).Worker(k_worker, { eval: true });
    worker.unref();
    return worker;
  }
  const url = URL.createObjectURL(new Blob([k_worker], { type: "text/javascript" }));
  const worker = new Worker(url);
  URL.revokeObjectURL(url);
  return worker;
}

// Resolves to a worker that looks for work. It does so until end() or for as long as the page lives.
async function startWorker(message) {
  const worker = await newWorker();
  await new Promise((ready, failed) => {
    const refused = () => failed(new Error("sandglass: a worker does not start. Load the library without threads."));
    if (worker.once) {
      worker.once("message", ready);
      worker.once("error", refused);
    } else {
      worker.onmessage = ready;
      worker.onerror = refused;
    }
    worker.postMessage(message);
  });
  return worker;
}

// Makes an instance of the library. `source` is a URL, bytes or a WebAssembly.Module; without it, sandglass.wasm beside
// this file. `options.now` is the clock of sandglass_clock_system(), in milliseconds; without it, performance.now().
// With `options.threads` above 1 there is a pool of so many, the calling one included: `sand.parallel` is for
// desc.parallel. `source` then is sandglass-threads.wasm. In a browser the page must be cross-origin isolated.
export async function load(source, options = {}) {
  const now = options.now ?? (() => performance.now());
  const threads = options.threads ?? 1;
  const module = await compile(source, threads);
  const shared = WebAssembly.Module.imports(module).some(({ kind }) => kind === "memory");
  let memory = shared
    ? new WebAssembly.Memory({ initial: k_shared_pages, maximum: k_shared_pages_at_most, shared })
    : undefined;
  let reading = 0n;
  const host = {
    clock_time_get(_clock, _precision, at) {
      // Browsers round their clock, up to 0.1 ms. One that stands still over several work units would count as broken.
      const told = BigInt(Math.round(now() * 1e6));
      reading = told > reading ? told : reading + k_least_step_ns;
      new DataView(memory.buffer).setBigUint64(at, reading, true);
      return 0;
    },
    proc_exit(code) {
      throw new Error(`sandglass: the module ended with code ${code}.`);
    },
  };
  const instance = await WebAssembly.instantiate(module, {
    wasi_snapshot_preview1: host,
    env: { memory, emscripten_notify_memory_growth() {} },
  });
  const { exports } = instance;
  memory ??= exports.memory;
  exports._initialize?.();
  const sand = new Sandglass(exports, memory, threads, module);
  const workers = await Promise.all(
    Array.from({ length: threads - 1 }, () =>
      startWorker({ module, memory, stack: sand.allocate(k_worker_stack) + k_worker_stack }),
    ),
  );
  sand.end = () => workers.forEach((worker) => worker.terminate());
  return sand;
}

class Sandglass {
  #exports;
  #memory;
  #classes = {};
  #reason;
  #blocks = new Map();
  #pointers = new Map(); // to C functions, by name
  #view;

  constructor(exports, memory, threads, module) {
    this.#exports = exports;
    this.#memory = memory;
    this.threads = threads;
    this.module = module;
    const classes = this.#classes; // each is made when it is first asked for
    for (const name of Object.keys(structs))
      Object.defineProperty(classes, name, {
        configurable: true,
        get: () => {
          const value = structClass(name, memory, () => this.view(), classes);
          Object.defineProperty(classes, name, { value });
          return value;
        },
      });
    this.#reason = this.allocate(8);
    for (const [name, [parameters, result, of, fails]] of Object.entries(functions))
      this[name] = this.#method(exports[name], parameters, result, of, fails);
  }

  get memory() {
    return this.#memory;
  }
  // The module's memory as it is now: ask again rather than keep it.
  view() {
    return this.#view?.buffer === this.#memory.buffer ? this.#view : (this.#view = new DataView(this.#memory.buffer));
  }
  // The pool, as sandglass_scene_desc.parallel; without threads, none.
  get helped() {
    return this.threads > 1 ? this.#exports.sandglass_web_pool_helped() >>> 0 : 0;
  }
  get parallel() {
    return { run: this.threads > 1 ? this.pointer("sandglass_web_pool_run") : 0, user: 0 };
  }

  #method(call, parameters, result, of, fails) {
    const converted = parameters.map((type) =>
      type === "u64" || type === "i64" ? BigInt : type === "ptr" ? address : Number,
    );
    const raw = (values) => converted.map((convert, i) => convert(values[i] ?? 0));
    if (fails)
      return (...values) => {
        const status = call(...raw(values), this.#reason);
        if (status === 0) return;
        const reason = this.text(this.view().getUint32(this.#reason, true));
        throw Object.assign(new Error(reason ?? this.sandglass_status_name(status)), { status });
      };
    if (result === "struct")
      // C returns it through an address that comes first
      return (...values) => {
        const to = this.make(of);
        call(to.address, ...raw(values));
        return to;
      };
    if (result === "text") return (...values) => this.text(call(...raw(values)));
    if (result === "u64") return (...values) => BigInt.asUintN(64, call(...raw(values)));
    if (result === "u32" || result === "ptr") return (...values) => call(...raw(values)) >>> 0;
    return (...values) => call(...raw(values));
  }

  // An aligned block of zeros. free() gives it back.
  allocate(bytes, alignment = k_block_alignment) {
    if (!(Number.isInteger(bytes) && bytes >= 0))
      throw new Error(
        `sandglass: allocate takes a whole number of bytes, not ${bytes}. Pass byteLength of a typed array.`,
      );
    // malloc would take a larger size modulo 2^32.
    const start = bytes < k_address_space - alignment ? this.#exports.malloc(bytes + alignment) >>> 0 : 0;
    if (start === 0) throw new Error(`sandglass: there is no memory for ${bytes} bytes. Make the scene smaller.`);
    const at = Math.ceil(start / alignment) * alignment;
    new Uint8Array(this.memory.buffer, at, bytes).fill(0);
    this.#blocks.set(at, start);
    return at;
  }

  free(block) {
    const start = this.#blocks.get(address(block));
    if (start === undefined) return;
    this.#blocks.delete(address(block));
    this.#exports.free(start);
  }

  // A new struct, with struct_size set where it has one, and `values` in its fields.
  make(name, values) {
    const view = this.at(name, this.allocate(structs[name].size));
    if (structs[name].fields[0][0] === "struct_size") view.struct_size = structs[name].size;
    return values ? view.set(values) : view;
  }

  // The struct at an address, or one of an array there.
  at(name, pointer, index = 0) {
    return new this.#classes[name](address(pointer) + index * structs[name].size);
  }
  // An array of structs: views, and the address of the first.
  array(name, count) {
    const size = structs[name].size;
    const first = this.allocate(size * count);
    const items = Array.from({ length: count }, (_, i) => this.at(name, first + i * size));
    return Object.assign(items, { address: first });
  }

  // Copies a typed array into the module's memory and gives the address.
  put(array) {
    if (!ArrayBuffer.isView(array))
      throw new Error(
        "sandglass: put takes a typed array, whose numbers have a size. Make one: Float32Array.from(array).",
      );
    const at = this.allocate(array.byteLength);
    new Uint8Array(this.memory.buffer, at).set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return at;
  }

  floats(pointer, count) {
    return new Float32Array(this.memory.buffer, address(pointer), count);
  }
  bytes(pointer, count) {
    return new Uint8Array(this.memory.buffer, address(pointer), count);
  }
  text(pointer) {
    if (!pointer) return null;
    const all = new Uint8Array(this.memory.buffer);
    let end = pointer;
    while (all[end] !== 0) ++end;
    return new TextDecoder().decode(all.slice(pointer, end)); // a copy: shared memory is not decoded
  }

  // A function pointer: of an exported C function by its name, or of a JavaScript function with a signature: the
  // result, then the parameters, "v" none, "i" 32 bits or a pointer, "j" 64 bits (a bigint), "f", "d".
  pointer(f, signature) {
    if (this.#pointers.has(f)) return this.#pointers.get(f);
    const table = this.#exports.__indirect_function_table;
    const index = table.grow(1);
    table.set(index, typeof f === "string" ? this.#exports[f] : trampoline(f, signature));
    if (typeof f === "string") this.#pointers.set(f, index);
    return index;
  }

  // Calls NAME_bytes and NAME_create with `description` before the block, and gives the handle. The block is freed by
  // destroy(handle).
  create(name, ...description) {
    const size = this.allocate(8);
    let block = 0;
    try {
      this[`${name}_bytes`](...description, size);
      const bytes = Number(this.view().getBigUint64(size, true));
      block = this.allocate(bytes);
      this[`${name}_create`](...description, block, bytes, size);
      const handle = this.view().getUint32(size, true);
      this.#blocks.set(handle, this.#blocks.get(block));
      return handle;
    } catch (error) {
      this.free(block);
      throw error;
    } finally {
      this.free(size);
    }
  }

  destroy(handle) {
    this.free(handle);
  }
}
