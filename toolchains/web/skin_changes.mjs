// A skin of the library (skin.h) as a renderer takes it.
export const k_vertex_bytes = 24, k_loose_words = 8;
const k_no_chunk = { version: 0, vertices: 0, vertex_count: 0, indices: 0, index_count: 0 };

// What changed of a skin since the call before: the chunks of its mesh, and all loose particles (their numbers as floats).
export class SkinChanges {
  constructor(sand, skin) { Object.assign(this, { sand, skin, mesh: sand.make("sandglass_skin_mesh"), versions: [], version: -1 }); }
  take() {
    const { sand, mesh, versions } = this, chunks = [];
    sand.sandglass_skin_get_mesh(this.skin, mesh);
    const { version, chunk_count, flying_count: flying, lying_count: lying } = mesh;
    if (version === this.version) return null;
    this.version = version;
    for (let number = 0; number < Math.max(chunk_count, versions.length); ++number) {
      const chunk = number < chunk_count ? sand.at("sandglass_skin_chunk", mesh.chunks, number) : k_no_chunk;
      if (versions[number] === chunk.version) continue;
      versions[number] = chunk.version;
      chunks.push({ number, vertices: sand.bytes(chunk.vertices, k_vertex_bytes * chunk.vertex_count), indices: new Uint16Array(sand.memory.buffer, chunk.indices, chunk.index_count) });
    }
    const words = k_loose_words * (flying + lying), loose = sand.floats(mesh.loose, words).slice(), numbers = new Uint32Array(loose.buffer);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < words; i += k_loose_words) {
      for (let k = 0; k < 3; ++k) low[k] = Math.min(low[k], loose[i + k]), high[k] = Math.max(high[k], loose[i + k]);
      loose[i + k_loose_words - 1] = numbers[i + k_loose_words - 1];
    }
    return { chunks, flying, lying, loose, low, high };
  }
}
