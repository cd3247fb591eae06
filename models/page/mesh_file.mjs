// Mesh files, by the program's own readers (mesh_reader.cpp).
// A function that takes the bytes of a file and its name, and gives its vertices, indices and remarks or throws what is wrong with
// it. `module` is mesh_reader.wasm; the decoder is meshoptimizer's.
export async function meshReader(module, MeshoptDecoder) {
  await MeshoptDecoder.ready;
  let memory;
  const bytes = (at, size) => new Uint8Array(memory.buffer, at, size);
  const text = (at) => {
    const all = bytes(at);
    return new TextDecoder().decode(all.slice(0, all.indexOf(0)));
  };
  const env = {
    unpack_meshopt(to, count, stride, from, size, mode, filter) {
      try {
        MeshoptDecoder.decodeGltfBuffer(
          bytes(to, count * stride),
          count,
          stride,
          bytes(from, size),
          text(mode),
          text(filter),
        );
        return 1;
      } catch {
        return 0;
      }
    },
    emscripten_notify_memory_growth() {},
  };
  const none = () => 0;
  const wasi = {
    fd_write: none,
    fd_close: none,
    fd_seek: none,
    environ_get: none,
    environ_sizes_get: none,
    proc_exit() {
      throw new Error("ended");
    },
  };
  const { exports } = (await WebAssembly.instantiate(module, { env, wasi_snapshot_preview1: wasi })).instance;
  memory = exports.memory;
  exports._initialize?.();
  const put = (content) => {
    const at = exports.malloc(content.length + 1);
    bytes(at, content.length).set(content);
    bytes(at, content.length + 1)[content.length] = 0;
    return at;
  };
  return (file, name) => {
    const at = put(file);
    const called = put(new TextEncoder().encode(name));
    try {
      const wrong = text(exports.mesh_read(at, file.length, called));
      if (wrong) throw new Error(wrong[0].toUpperCase() + wrong.slice(1));
      return {
        remarks: text(exports.mesh_remarks()),
        vertices: new Float32Array(memory.buffer, exports.mesh_vertices(), 3 * exports.mesh_vertex_count()).slice(),
        indices: new Uint32Array(memory.buffer, exports.mesh_indices(), 3 * exports.mesh_triangle_count()).slice(),
      };
    } finally {
      exports.free(at);
      exports.free(called);
    }
  };
}

// Scales a mesh to a height, or to less where it would be wider than `width`, and puts the middle of its base at the
// origin.
export function standing({ vertices, indices }, height, width) {
  const low = [0, 1, 2].map((axis) =>
    vertices.reduce((least, x, i) => (i % 3 === axis ? Math.min(least, x) : least), Infinity),
  );
  const high = [0, 1, 2].map((axis) =>
    vertices.reduce((most, x, i) => (i % 3 === axis ? Math.max(most, x) : most), -Infinity),
  );
  if (!(high[1] > low[1])) throw new Error("The mesh is flat, so it has no volume. Turn it: y is up.");
  const scale = Math.min(height / (high[1] - low[1]), width / Math.max(high[0] - low[0], high[2] - low[2]));
  const middle = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2];
  return { vertices: vertices.map((x, i) => (x - middle[i % 3]) * scale), indices };
}

// The corners of triangles with a normal each: the mean, by area, of the triangles there that are turned by less than 40 degrees.
export function smoothed(vertices, indices) {
  const k_crease = 0.766;
  const corners = new Float32Array(3 * indices.length);
  const faces = new Float32Array(indices.length);
  const normals = new Float32Array(corners.length);
  const at = new Map();
  for (let i = 0; i < indices.length; ++i)
    for (let k = 0; k < 3; ++k) corners[3 * i + k] = vertices[3 * indices[i] + k];
  for (let t = 0; t < indices.length; t += 3) {
    const [a, b, c] = [0, 3, 6].map((k) => corners.subarray(3 * t + k, 3 * t + k + 3));
    const [x, y, z] = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    const [u, v, w] = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    faces.set([y * w - z * v, z * u - x * w, x * v - y * u], t);
    for (let k = 0; k < 3; ++k) {
      const key = corners.subarray(3 * (t + k), 3 * (t + k) + 3).join();
      at.set(key, [...(at.get(key) ?? []), t]);
    }
  }
  const size = (t) => Math.hypot(faces[t], faces[t + 1], faces[t + 2]);
  const dot = (s, t) => faces[s] * faces[t] + faces[s + 1] * faces[t + 1] + faces[s + 2] * faces[t + 2];
  for (let i = 0; i < indices.length; ++i) {
    const own = i - (i % 3);
    for (const other of at.get(corners.subarray(3 * i, 3 * i + 3).join()))
      if (other === own || dot(own, other) > k_crease * size(own) * size(other))
        for (let k = 0; k < 3; ++k) normals[3 * i + k] += faces[other + k];
  }
  return { corners, normals };
}
