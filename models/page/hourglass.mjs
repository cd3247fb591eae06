// The page's hourglass: what it is made of, as it was made beforehand (hourglass_shape.mjs), and how it is turned over.
// Coordinates are its own: the axis is y, the neck lies at the origin. Metres.
export const k_throat = 0.0125; // radius of the glass within, at the neck
export const k_half = 0.115; // half its height
export const k_cap = 0.012; // height of the wood at each end
export const k_glass_radius = 0.0035; // of the sand in it
export const k_glass_particles = 1320; // its lower half is full
const k_turn_seconds = 1.2;
const k_lift = 0.03; // so that it clears the table while it turns
const k_slowest = 0.3; // of that, in slow motion
export const k_stands = k_half + k_cap; // the neck over the table

// What is seen of the stream below: as of a nozzle.
export const k_neck = { position: [0, k_stands, 0], radius: 1.3 * k_throat, speed: 0.12 };

// The arrays of bytes that hourglass_shape.mjs wrote, each after its size.
export function hourglassMade(buffer) {
  const view = new DataView(buffer);
  let at = 0;
  const next = (Numbers) => {
    const size = view.getUint32(at, true);
    at += 4 + size;
    return new Numbers(buffer, at - size, size / Numbers.BYTES_PER_ELEMENT);
  };
  const mesh = () => ({ vertices: next(Float32Array), indices: next(Uint32Array), normals: next(Float32Array) });
  return { field: next(Uint8Array), below: next(Float32Array), wood: mesh(), glass: mesh(), funnel: mesh() };
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
