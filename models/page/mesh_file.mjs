// Mesh files, by the program's own readers (mesh_reader.cpp).
import { MeshoptDecoder } from "./meshopt_decoder.mjs";

// A function that takes the bytes of a file and its name, and gives its vertices, indices and remarks or throws what is wrong with
// it. `module` is mesh_reader.wasm.
export async function meshReader(module) {
  await MeshoptDecoder.ready;
  let memory;
  const bytes = (at, size) => new Uint8Array(memory.buffer, at, size);
  const text = (at) => { const all = bytes(at); return new TextDecoder().decode(all.slice(0, all.indexOf(0))); };
  const env = {
    unpack_meshopt(to, count, stride, from, size, mode, filter) {
      try { MeshoptDecoder.decodeGltfBuffer(bytes(to, count * stride), count, stride, bytes(from, size), text(mode), text(filter)); return 1; } catch { return 0; }
    },
    emscripten_notify_memory_growth() {},
  };
  const none = () => 0, wasi = { fd_write: none, fd_close: none, fd_seek: none, environ_get: none, environ_sizes_get: none, proc_exit() { throw new Error("ended"); } };
  const { exports } = (await WebAssembly.instantiate(module, { env, wasi_snapshot_preview1: wasi })).instance;
  memory = exports.memory;
  exports._initialize?.();
  const put = (content) => { const at = exports.malloc(content.length + 1); bytes(at, content.length).set(content), bytes(at, content.length + 1)[content.length] = 0; return at; };
  return (file, name) => {
    const at = put(file), called = put(new TextEncoder().encode(name));
    try {
      const wrong = text(exports.mesh_read(at, file.length, called));
      if (wrong) throw new Error(wrong[0].toUpperCase() + wrong.slice(1));
      return { remarks: text(exports.mesh_remarks()), vertices: new Float32Array(memory.buffer, exports.mesh_vertices(), 3 * exports.mesh_vertex_count()).slice(),
        indices: new Uint32Array(memory.buffer, exports.mesh_indices(), 3 * exports.mesh_triangle_count()).slice() };
    } finally { exports.free(at), exports.free(called); }
  };
}

// Scales a mesh to a height, or to less where it would be wider than `width`, and puts the middle of its base at the
// origin.
export function standing({ vertices, indices }, height, width) {
  const low = [0, 1, 2].map((axis) => vertices.reduce((least, x, i) => (i % 3 === axis ? Math.min(least, x) : least), Infinity));
  const high = [0, 1, 2].map((axis) => vertices.reduce((most, x, i) => (i % 3 === axis ? Math.max(most, x) : most), -Infinity));
  if (!(high[1] > low[1])) throw new Error("The mesh is flat, so it has no volume. Turn it: y is up.");
  const scale = Math.min(height / (high[1] - low[1]), width / Math.max(high[0] - low[0], high[2] - low[2])), middle = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2];
  return { vertices: vertices.map((x, i) => (x - middle[i % 3]) * scale), indices };
}
