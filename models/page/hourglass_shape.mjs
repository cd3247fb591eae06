// Makes the page's hourglass while the page is built, so that no device waits for it: its shape as a field of the library,
// what of it is drawn, and places of its sand. node hourglass_shape.mjs NPM_FOLDER OUTPUT
import { writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { k_cap, k_glass_particles, k_glass_radius, k_half, k_stands, k_throat } from "./hourglass.mjs";

const [npm, output] = process.argv.slice(2);
const { load, constants } = await import(`${pathToFileURL(npm)}/sandglass.mjs`);

const k_bulb = 0.052; // radius of the glass within
const k_glass = 0.0025; // its thickness
const k_rim = 0.066; // radius of the wood at each end
const k_pillar = 0.0045;
const k_pillars = 3;
const k_around = 48; // corners of a circle
const k_spacing = 0.0042;
const k_rounded = 2 ** 20; // of a metre: a thousandth of a millimetre is enough, and compresses to less than half

function radius(height) {
  const t = Math.min(1, Math.abs(height) / k_half);
  const open = Math.sin(0.5 * Math.PI * Math.min(1, t / 0.6));
  const round = t > 0.72 ? Math.sqrt(1 - 0.5 * ((t - 0.72) / 0.28) ** 2) : 1;
  return (k_throat + (k_bulb - k_throat) * open ** 2.2) * round;
}

const k_half_parts = 48;
const k_profile = Array.from({ length: 2 * k_half_parts + 1 }, (_, i) => {
  const y = k_half * (i / k_half_parts - 1);
  return [radius(y), y];
});

const rounded = (x) => Math.round(x * k_rounded) / k_rounded;
const k_line = Float64Array.from(k_profile.slice(k_half_parts).flat()); // of the upper half

// How far a place is from the glass, above 0 within. The line is followed from its height on, up and down, while it may be nearer
// than it is there.
function distance(x, y, z) {
  const out = Math.sqrt(x * x + z * z);
  const height = Math.abs(y);
  const last = k_line.length - 2;
  const part = Math.min(k_half_parts - 1, Math.floor((height / k_half) * k_half_parts));
  const begin = 2 * part;
  if (height > k_half && out < k_line[last]) return k_half - height;
  const level = out - k_line[begin] - ((height / k_half) * k_half_parts - part) * (k_line[begin + 2] - k_line[begin]);
  let square = Math.min((k_half - height) ** 2, height < k_half ? level ** 2 : Infinity);
  for (let step = 2; step >= -2; step -= 4)
    for (let i = step > 0 ? begin : begin - 2; i >= 0 && i < last; i += step) {
      const a = k_line[i];
      const b = k_line[i + 1];
      const u = k_line[i + 2] - a;
      const v = k_line[i + 3] - b;
      const right = out - a;
      const above = height - b;
      if ((step > 0 ? above < 0 && above ** 2 : above > v && (above - v) ** 2) > square) break;
      const along = (right * u + above * v) / (u * u + v * v);
      const s = along < 0 ? 0 : along > 1 ? 1 : along;
      square = Math.min(square, (right - s * u) ** 2 + (above - s * v) ** 2);
    }
  return Math.sqrt(square) * (height < k_half && out < radius(height) ? 1 : -1);
}

function hourglassField(sand) {
  const [wide, high] = [k_bulb, k_half].map((reach) => k_spacing * Math.ceil(reach / k_spacing + 2));
  const desc = sand.make("sandglass_field_desc");
  sand.sandglass_field_desc_default(desc);
  desc.set({
    solid: constants.SANDGLASS_SOLID_OUTSIDE,
    bounds_min: [-wide, -high, -wide],
    bounds_max: [wide, high, wide],
    spacing: k_spacing,
    distance: sand.pointer((_, at) => rounded(distance(...sand.floats(at, 3))), "fii"),
  });
  const size = sand.allocate(8);
  sand.sandglass_field_bytes(desc, size);
  const bytes = Number(sand.view().getBigUint64(size, true));
  return sand.bytes(sand.create("sandglass_field", desc), bytes).slice();
}

// Places of so many particles in the lower half, from below.
function sandBelow(count, r) {
  const places = [];
  const step = 2.02 * r;
  for (let y = -k_half + 1.05 * r; places.length < 3 * count && y < 0; y += step)
    for (let z = -k_bulb; z < k_bulb; z += step)
      for (let x = -k_bulb; x < k_bulb && places.length < 3 * count; x += step)
        if (distance(x, y, z) > 1.05 * r) places.push(x, y + k_stands, z);
  return Float32Array.from(places);
}

// Triangles of a surface of revolution: `line` holds radii and heights, from below.
function lathed(line, [x0, z0] = [0, 0], corners = k_around) {
  const vertices = [];
  const indices = [];
  const n = line.length;
  for (let k = 0; k < corners; ++k) {
    const cosine = Math.cos((2 * Math.PI * k) / corners);
    const sine = Math.sin((2 * Math.PI * k) / corners);
    for (const [r, y] of line) vertices.push(x0 + r * cosine, y, z0 - r * sine);
  }
  for (let k = 0; k < corners; ++k)
    for (let i = 0; i + 1 < n; ++i) {
      const a = k * n + i;
      const b = ((k + 1) % corners) * n + i;
      indices.push(a, b, b + 1, a, b + 1, a + 1);
    }
  return { vertices, indices };
}

function joined(parts) {
  const vertices = parts.flatMap((part) => part.vertices);
  const indices = [];
  let first = 0;
  for (const part of parts) {
    indices.push(...part.indices.map((i) => i + first));
    first += part.vertices.length / 3;
  }
  return { vertices: Float32Array.from(vertices), indices: Uint32Array.from(indices) };
}

function smooth(line) {
  const { vertices, indices } = lathed(line);
  const n = line.length;
  const normals = new Float32Array(vertices.length);
  const flat = line.map((_, i) => {
    const [a, b] = line[Math.max(0, i - 1)];
    const [c, d] = line[Math.min(n - 1, i + 1)];
    const l = Math.hypot(c - a, d - b);
    return [(d - b) / l, (a - c) / l];
  });
  for (let k = 0, at = 0; k < k_around; ++k) {
    const cosine = Math.cos((2 * Math.PI * k) / k_around);
    const sine = Math.sin((2 * Math.PI * k) / k_around);
    for (const [out, up] of flat) {
      normals[at++] = out * cosine;
      normals[at++] = up;
      normals[at++] = -out * sine;
    }
  }
  return { vertices: Float32Array.from(vertices), indices: Uint32Array.from(indices), normals };
}
const glassMesh = () => smooth(k_profile.filter((_, i) => i % 2 === 0).map(([r, y]) => [r + k_glass, y]));
// What sand is poured from; its spout ends below the nozzle, where the stream is as narrow as it.
const funnelMesh = () =>
  smooth([
    [0.0088, -0.03],
    [0.0088, -0.029],
    [0.0095, 0.012],
    [0.012, 0.018],
    [0.042, 0.055],
    [0.0425, 0.06],
    [0.042, 0.061],
    [0.041, 0.06],
    [0.01, 0.017],
  ]);
function woodMesh() {
  const end = (from) =>
    lathed([
      [0, from],
      [k_rim - 0.003, from],
      [k_rim, from + 0.003],
      [k_rim, from + k_cap - 0.003],
      [k_rim - 0.003, from + k_cap],
      [0, from + k_cap],
    ]);
  const pillars = Array.from({ length: k_pillars }, (_, i) => (2 * Math.PI * (i + 0.25)) / k_pillars).map((turn) =>
    lathed(
      [
        [k_pillar, -k_half],
        [k_pillar, k_half],
      ],
      [(k_rim - 2 * k_pillar) * Math.cos(turn), (k_rim - 2 * k_pillar) * Math.sin(turn)],
      12,
    ),
  );
  return joined([end(-k_half - k_cap), end(k_half), ...pillars]);
}

const arrays = ({ vertices, indices, normals = new Float32Array(0) }) => [
  vertices.map(rounded),
  indices,
  normals.map(rounded),
];
const meshes = [woodMesh(), glassMesh(), funnelMesh()].flatMap(arrays);
const all = [hourglassField(await load()), sandBelow(k_glass_particles, k_glass_radius), ...meshes];
const parts = all.flatMap((array) => [Uint32Array.of(array.byteLength), array]);
writeFileSync(
  output,
  Buffer.concat(parts.map(({ buffer, byteOffset, byteLength }) => Buffer.from(buffer, byteOffset, byteLength))),
);
