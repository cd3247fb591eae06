// The block of packed grains that the sand kit draws with: its levels, one after another. `bytes` are sand_block.wasm.
export async function sandBlock(bytes) {
  const k_texels = 64;
  const nothing = new Proxy({}, { get: () => () => 0 }); // what it imports for failures
  const { exports } = (await WebAssembly.instantiate(bytes, { env: nothing, wasi_snapshot_preview1: nothing }))
    .instance;
  exports._initialize?.();
  let size = 0;
  for (let side = k_texels; side >= 1; side >>= 1) size += 8 * side ** 3;
  const at = exports.sand_block_make(0); // its memory may grow meanwhile
  return new Uint8Array(exports.memory.buffer, at, size).slice();
}
