// Sand's mesh as engines take it: an array for each attribute, as an engine has one type of number in an array.
import { k_loose_words } from "./skin_changes.mjs";

const k_vertex_words = 6;

// Of a chunk: `positions` (3 floats); `normals` (4 signed bytes: the normal, how hollow it is); `origins` (4 words of 16 bits: the
// origin of the block, micrometres over what the sand lies on + 32768), to be read normalised; and the box that holds it. `first`: the
// renderer takes what is flat from a triangle's first corner.
export function chunkArrays({ vertices, indices }, first) {
  const words = new Uint32Array(vertices.slice().buffer);
  const count = words.length / k_vertex_words;
  const positions = new Uint32Array(3 * count);
  const normals = new Uint32Array(count);
  const origins = new Uint32Array(2 * count);
  for (let i = 0, at = 0; i < count; ++i, at += k_vertex_words) {
    positions[3 * i] = words[at];
    positions[3 * i + 1] = words[at + 1];
    positions[3 * i + 2] = words[at + 2];
    normals[i] = words[at + 3] ^ 0x80000000; // a byte from 0 to 255 as one from -128 to 127
    origins[2 * i] = words[at + 4];
    origins[2 * i + 1] = words[at + 5] ^ 0x80000000;
  }
  const corners = indices.slice();
  if (first)
    for (let i = 0; i < corners.length; i += 3)
      [corners[i], corners[i + 1], corners[i + 2]] = [corners[i + 2], corners[i], corners[i + 1]];
  const floats = new Float32Array(positions.buffer);
  return {
    positions: floats,
    normals: new Int8Array(normals.buffer),
    origins: new Uint16Array(origins.buffer),
    indices: corners,
    ...boxOf(floats),
  };
}

function boxOf(positions) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  return { low, high };
}

// What lies and what flies, eight floats a particle: its place and weight, its vector, its number.
export const looseLists = ({ flying, lying, loose }) => [
  loose.subarray(k_loose_words * flying, k_loose_words * (flying + lying)),
  loose.subarray(0, k_loose_words * flying),
];
