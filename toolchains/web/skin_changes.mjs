// A skin of the library (skin.h) as a renderer takes it.
export const k_vertex_bytes = 24;
export const k_loose_words = 8;
const k_no_chunk = { version: 0, vertices: 0, vertex_count: 0, indices: 0, index_count: 0 };

// What changed of a skin since the call before: the chunks of its mesh, and all loose particles (their numbers as floats).
export class SkinChanges {
  #sand;
  #mesh;
  #versions = [];
  #version = -1;

  constructor(sand, skin) {
    this.#sand = sand;
    this.skin = skin;
    this.#mesh = sand.make("sandglass_skin_mesh");
  }

  take() {
    const sand = this.#sand;
    sand.sandglass_skin_get_mesh(this.skin, this.#mesh);
    const { version, flying_count: flying, lying_count: lying } = this.#mesh;
    if (version === this.#version) return null;
    this.#version = version;
    return { chunks: this.#takeChunks(), flying, lying, ...this.#takeLoose(flying + lying) };
  }

  #takeChunks() {
    const sand = this.#sand;
    const versions = this.#versions;
    const { chunks, chunk_count } = this.#mesh;
    const changed = [];
    for (let number = 0; number < Math.max(chunk_count, versions.length); ++number) {
      const chunk = number < chunk_count ? sand.at("sandglass_skin_chunk", chunks, number) : k_no_chunk;
      if (versions[number] === chunk.version) continue;
      versions[number] = chunk.version;
      changed.push({
        number,
        vertices: sand.bytes(chunk.vertices, k_vertex_bytes * chunk.vertex_count),
        indices: new Uint16Array(sand.memory.buffer, chunk.indices, chunk.index_count),
      });
    }
    return changed;
  }

  // With the box that holds them.
  #takeLoose(count) {
    const words = k_loose_words * count;
    const loose = this.#sand.floats(this.#mesh.loose, words).slice();
    const numbers = new Uint32Array(loose.buffer);
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < words; i += k_loose_words) {
      for (let k = 0; k < 3; ++k) {
        low[k] = Math.min(low[k], loose[i + k]);
        high[k] = Math.max(high[k], loose[i + k]);
      }
      loose[i + k_loose_words - 1] = numbers[i + k_loose_words - 1];
    }
    return { loose, low, high };
  }
}
