/** An address in the module's memory; 0 is NULL. */
export type Pointer = number;

declare const of: unique symbol;
/** What create() gave. One of a room is none of a scene, and no number is one. */
export type Handle<Name extends string> = number & { readonly [of]: Name };
/** An address that was read from a field. */
export type PointerTo<Item> = number & { readonly [of]: Item };

/** An array in a struct. It reads and writes the module's memory as it is then, also after that has grown. */
export interface Numbers<Copy = unknown> extends Iterable<number> {
  readonly address: Pointer;
  readonly length: number;
  [index: number]: number;
  set(values: ArrayLike<number>, first?: number): void;
  fill(value: number): this;
  slice(begin?: number, end?: number): Copy;
}

/** A struct in the module's memory. */
export interface Struct<Name extends string = string> {
  readonly [of]: Name;
  readonly address: Pointer;
  /** Copies a struct of the same type, or fields by name. */
  set(values: this | Values<this>): this;
}

/** Values for fields: arrays of numbers for arrays, and structs or addresses for pointers. */
export type Values<T> = {
  [Name in Exclude<keyof T, keyof Struct>]?: T[Name] extends Numbers
    ? ArrayLike<number>
    : T[Name] extends Struct
      ? T[Name] | Values<T[Name]>
      : T[Name] extends PointerTo<infer Item>
        ? Item | Pointer | null
        : number extends T[Name]
          ? number | bigint
          : T[Name];
};

/** The library, and what JavaScript needs besides. */
export interface Sandglass extends Functions {
  readonly memory: WebAssembly.Memory;
  readonly module: WebAssembly.Module;
  /** The memory as it is now: ask again in every frame rather than keep it. */
  view(): DataView;
  /** How many threads the pool has, the calling one included. */
  readonly threads: number;
  /** Ends the pool's other threads. No call may follow. */
  end(): void;
  /** Tasks that other threads did, modulo 2^32. */
  readonly helped: number;
  /** The pool, for desc.parallel.set(). */
  readonly parallel: { run: Pointer; user: Pointer };
  /** An aligned block of zeros, of a whole number of bytes. */
  allocate(bytes: number, alignment?: number): Pointer;
  free(block: Pointer | Struct): void;
  /** A new struct, with struct_size set where it has one, and `values` in its fields. */
  make<Name extends keyof Structs>(name: Name, values?: Structs[Name] | Values<Structs[Name]>): Structs[Name];
  /** The struct at an address, or one of an array there. */
  at<Name extends keyof Structs>(name: Name, pointer: Pointer, index?: number): Structs[Name];
  /** An array of structs. */
  array<Name extends keyof Structs>(name: Name, count: number): Structs[Name][] & { readonly address: Pointer };
  /** Copies a typed array into the module's memory. */
  put(array: ArrayBufferView): Pointer;
  /** Views of the module's memory. They end when it grows: ask again in every frame rather than keep them. */
  floats(pointer: Pointer | Numbers, count: number): Float32Array;
  bytes(pointer: Pointer | Numbers, count: number): Uint8Array;
  text(pointer: Pointer): string | null;
  /** A function pointer: of a C function by its name, or of a JavaScript function. The signature is the result, then
   * the parameters: "v" none, "i" 32 bits or a pointer, "j" 64 bits (a bigint), "f", "d". */
  pointer(f: keyof Functions): Pointer;
  pointer(f: (...parameters: any[]) => any, signature: string): Pointer;
  /** Calls NAME_bytes and NAME_create in a new block, and gives the handle: create("sandglass_scene", desc). */
  create<Name extends keyof Descriptions>(name: Name, ...description: Descriptions[Name]): Handle<Name>;
  /** Frees the block of a handle. */
  destroy(handle: Handle<string>): void;
}

/** Makes an instance of the library: from a URL, bytes or a module; without it, sandglass.wasm beside this file. `now`
 * is the clock of sandglass_clock_system(), in milliseconds; without it, performance.now(). With `threads` above 1 there
 * is a pool of so many, the calling one included, and the module is sandglass-threads.wasm. A page must be cross-origin
 * isolated for it. The workers live until end(), or as long as the page. */
export declare function load(
  source?: URL | string | BufferSource | WebAssembly.Module,
  options?: { now?: () => number; threads?: number },
): Promise<Sandglass>;
