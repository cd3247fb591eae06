// An hourglass: its shape as a field of the library, what of it is drawn, the sand in it, and how it is turned over.
// Coordinates are its own: the axis is y, the neck lies at the origin. Metres.
import { constants } from "./sandglass.mjs";

const k_throat = 0.0125; // radii of the glass within
const k_bulb = 0.052;
const k_half = 0.115; // half its height
const k_glass = 0.0025;
const k_cap = 0.012;
const k_rim = 0.066; // its thickness; height and radius of the wood at each end
const k_pillar = 0.0045;
const k_pillars = 3;
const k_around = 48; // corners of a circle
const k_spacing = 0.0042;
const k_turn_seconds = 1.2;
const k_lift = 0.03; // so that it clears the table while it turns
const k_slowest = 0.3; // of that, in slow motion
const k_stands = k_half + k_cap; // the neck over the table

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

const k_line = Float64Array.from(k_profile.slice(k_half_parts).flat()); // of the upper half

// What is seen of the stream below: as of a nozzle.
export const k_neck = { position: [0, k_stands, 0], radius: 1.3 * k_throat, speed: 0.12 };

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

export function hourglassField(sand) {
  const desc = sand.make("sandglass_field_desc");
  const [wide, high] = [k_bulb, k_half].map((reach) => k_spacing * Math.ceil(reach / k_spacing + 2));
  sand.sandglass_field_desc_default(desc);
  // It is round, and its nodes lie at multiples of the spacing from the neck: up to sixteen have one distance.
  const nodes = Math.round(high / k_spacing) + 2;
  const known = new Float32Array(2 * nodes ** 3).fill(NaN);
  let floats = sand.floats(0, 0);
  const asked = sand.pointer((_, at) => {
    if (floats.length === 0) floats = new Float32Array(sand.memory.buffer); // it has grown
    const i = at >> 2;
    const x = Math.round(floats[i] / k_spacing);
    const y = Math.abs(Math.round(floats[i + 1] / k_spacing));
    const z = Math.round(floats[i + 2] / k_spacing);
    const key = (x * x + z * z) * nodes + y;
    if (Number.isNaN(known[key])) known[key] = distance(k_spacing * x, k_spacing * y, k_spacing * z);
    return known[key];
  }, "fii");
  desc.set({
    solid: constants.SANDGLASS_SOLID_OUTSIDE,
    bounds_min: [-wide, -high, -wide],
    bounds_max: [wide, high, wide],
    spacing: k_spacing,
    distance: asked,
  });
  const field = sand.create("sandglass_field", desc);
  sand.free(desc);
  return field;
}

// Places of so many particles in the lower half, from below.
export function sandBelow(count, r) {
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
export const glassMesh = () => smooth(k_profile.filter((_, i) => i % 2 === 0).map(([r, y]) => [r + k_glass, y]));
// What sand is poured from; its spout ends below the nozzle, where the stream is as narrow as it.
export const funnelMesh = () =>
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
export function woodMesh() {
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

// How it stands, and how it moves when it is turned over about a level axis.
export class Turning {
  share = 1; // of a turn
  constructor() {
    this.from = [0, 0, 0, 1];
    this.axis = [0, 0, 1];
  }
  get turns() {
    return this.share < 1;
  }
  begin(axis) {
    if (this.turns) return;
    this.from = this.pose().rotation;
    this.axis = axis;
    this.share = 0;
  }
  // Moves on, and gives pose and velocities over that time. `flow`: the share of it that sand was simulated for lately; `late`:
  // how much more of the user's time it takes. In slow motion it turns as slowly, as far as is worth waiting for.
  advance(seconds, flow = 1, late = 1) {
    const before = this.angle();
    const height = this.pose().position[1];
    this.share = Math.min(1, this.share + (Math.max(k_slowest * late, flow) * seconds) / k_turn_seconds);
    const now = this.pose();
    const rate = (this.angle() - before) / seconds;
    return {
      ...now,
      linear_velocity: [0, (now.position[1] - height) / seconds, 0],
      angular_velocity: this.axis.map((x) => x * rate),
    };
  }
  // 0 as it stands, 1 while it needs the most room.
  get wide() {
    const x = Math.min(1, Math.min(this.share, 1 - this.share) / 0.3);
    return x * x * (3 - 2 * x);
  }
  angle() {
    const s = this.share;
    return Math.PI * s * s * s * (10 + s * (6 * s - 15));
  }
  pose() {
    const half = this.angle() / 2;
    const [x, y, z] = this.axis.map((c) => c * Math.sin(half));
    const w = Math.cos(half);
    const [a, b, c, d] = this.from;
    const rotation = [
      w * a + x * d + y * c - z * b,
      w * b - x * c + y * d + z * a,
      w * c + x * b - y * a + z * d,
      w * d - x * a - y * b - z * c,
    ];
    return { position: [0, k_stands + k_lift * Math.sin(Math.PI * this.share) ** 2, 0], rotation };
  }
}
