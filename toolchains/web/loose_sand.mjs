// What the kit's loose.glsl is given, by every painter: numbers, indices of squares, and how many of them are needed.
const k_grain_radius = 0.0003;
const k_stream_narrow = 0.3;
const k_minerals = [
  [0.8, 0.66, 0.46, 0.62],
  [0.9, 0.83, 0.72, 0.24],
  [0.58, 0.34, 0.17, 0.09],
  [0.13, 0.115, 0.1, 0.05],
]; // as in sand_block.cpp
export const k_block_side = 0.0084;
// Of what lies and of what flies: squares of a particle at most, and how thin none is drawn, as in loose.glsl.
const k_grains = [256, 384];
const k_pixels = [1.5, 1.2];

export const squareIndices = () =>
  new Uint16Array(6 * k_grains[1]).map((_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]);

// How many squares the nearest particle of a box needs; the shader leaves out what the others do not. `pixels`: of a metre at a
// distance of one; `share`: of all grains.
export function grainsNeeded(flies, { low, high }, eye, pixels, share = 1) {
  const away = Math.max(0.1, Math.hypot(...[0, 1, 2].map((k) => Math.max(low[k] - eye[k], 0, eye[k] - high[k]))));
  const seen = k_grains[flies] * ((2 * k_grain_radius * pixels) / away / k_pixels[flies]) ** 2;
  return Math.max(1, Math.ceil(Math.min(share * k_grains[flies], seen)));
}

const rows = (count, of) => Array.from({ length: count }, (_, i) => [0, 1, 2, 3].map((k) => of(i, k)));
// Values of the uniforms.
export const looseValues = (radius, streams) => ({
  particle_radius: radius,
  frame_seconds: 1 / 60,
  stream_narrow: k_stream_narrow,
  minerals: rows(4, (m, k) =>
    k < 3 ? k_minerals[m][k] : k_minerals.slice(0, m + 1).reduce((sum, mineral) => sum + mineral[3], 0),
  ),
  streams: rows(3, (s, k) => streams[s]?.nozzle[k] ?? 0),
  stream_ways: rows(3, (s, k) => streams[s]?.way[k] ?? 0),
});
