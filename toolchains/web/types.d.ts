/** A struct in the module's memory. */
export interface Struct {
  readonly address: Pointer;
  /** Copies a struct of the same type, or fields by name. */
  set(values: Values<this>): this;
}

/** Values for fields: arrays of numbers for arrays, and structs or addresses for pointers. */
export type Values<T> = {
  [Name in keyof T]?: T[Name] extends { readonly length: number } ? ArrayLike<number>
    : T[Name] extends Struct ? Values<T[Name]>
    : T[Name] extends number ? number | bigint | Struct | null
    : T[Name];
};

/** The library, and what JavaScript needs besides. */
export interface Sandglass extends Functions {
  readonly memory: WebAssembly.Memory;
  /** How many threads the pool has, the calling one included. */
  readonly threads: number;
  /** Tasks that other threads did, modulo 2^32. */
  readonly helped: number;
  /** The pool, for desc.parallel.set(). */
  readonly parallel: { readonly run: Pointer; readonly user: Pointer };
  /** An aligned block of zeros. */
  allocate(bytes: number, alignment?: number): Pointer;
  free(block: Pointer | Struct): void;
  /** A new struct, with struct_size set where it has one, and `values` in its fields. */
  make<Name extends keyof Structs>(name: Name, values?: Values<Structs[Name]>): Structs[Name];
  /** The struct at an address, or one of an array there. */
  at<Name extends keyof Structs>(name: Name, pointer: Pointer, index?: number): Structs[Name];
  /** An array of structs. */
  array<Name extends keyof Structs>(name: Name, count: number): Structs[Name][] & { readonly address: Pointer };
  /** Copies a typed array into the module's memory. */
  put(array: ArrayBufferView): Pointer;
  /** Views of the module's memory. They end when it grows. */
  floats(pointer: Pointer, count: number): Float32Array;
  bytes(pointer: Pointer, count: number): Uint8Array;
  text(pointer: Pointer): string | null;
  /** A function pointer: of a C function by its name, or of a JavaScript function. The signature is the result, then
   * the parameters: "v" none, "i" 32 bits or a pointer, "j" 64 bits (a bigint), "f", "d". */
  pointer(f: keyof Functions): Pointer;
  pointer(f: (...parameters: any[]) => any, signature: string): Pointer;
  /** Calls NAME_bytes and NAME_create in a new block, and gives the handle: create("sandglass_scene", desc). */
  create(name: string, ...description: unknown[]): Pointer;
  /** Frees the block of a handle. */
  destroy(handle: Pointer): void;
}

/** Makes an instance of the library: from a URL, bytes or a module; without it, sandglass.wasm beside this file. `now`
 * is the clock of sandglass_clock_system(), in milliseconds; without it, performance.now(). With `threads` above 1 there
 * is a pool of so many, the calling one included, and the module is sandglass-threads.wasm. A page must be cross-origin
 * isolated for it. The workers live as long as the page. */
export declare function load(source?: URL | string | BufferSource | WebAssembly.Module,
                             options?: { now?: () => number; threads?: number }): Promise<Sandglass>;
