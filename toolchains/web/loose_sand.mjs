// What the kit's loose.glsl is given, by every painter: numbers, indices of squares, and how many of them are needed.
import { k_loose_words } from "./skin_changes.mjs";

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

// How many squares the particle that needs most of them has; the shader leaves out what the others do not need. `view` is that of the
// particles' space; `pixels`: of a metre at a distance of one; `share`: of all grains.
export function grainsNeeded(flies, particles, view, projection, pixels, share = 1) {
  const most = k_grains[flies];
  const nearest = (2 * k_grain_radius * pixels) / k_pixels[flies]; // has more than one grain up to there
  const [x, y, z, w] = [0, 4, 8, 12].map((at) =>
    [0, 1, 2, 3].reduce((sum, k) => sum + projection[4 * k + 3] * view[at + k], 0),
  );
  let needed = 1;
  for (let i = 0; i < particles.length; i += k_loose_words) {
    const away = x * particles[i] + y * particles[i + 1] + z * particles[i + 2] + w;
    const seen = Math.min(Math.max((nearest / away) ** 2, 1 / most), 1) * particles[i + 3];
    if (away > 0) needed = Math.max(needed, most * seen);
  }
  return Math.ceil(Math.min(needed, share * most));
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
