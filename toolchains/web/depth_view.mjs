// What receiveByDepth takes, in any engine, as values of the kit's uniforms (depth.glsl). Matrices are column-major.
import { checked } from "./options.mjs";

const k_kinds = { depth: 0, metres: 1, camera: 0, fromView: 16, heights: 0 };
const k_nearly = 0.9999; // of the depth of what a depth buffer shows nothing at
const k_farthest = 1e6; // metres, of a texture that has them
const k_identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const k_flipped = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]; // y of a picture from its other end
const k_picture = [0.5, 0, 0, 0, 0, -0.5, 0, 0, 0, 0, 0, 0, 0.5, 0.5, 0, 1]; // from clip space, its upper left corner first
export const depthNames = [
  "sandglass_to_depth",
  "sandglass_from_depth",
  "sandglass_to_heights",
  "sandglass_metres",
  "sandglass_known",
];

const product = (a, b) =>
  Array.from({ length: 16 }, (_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + a[(i % 4) + 4 * k] * b[(i & 12) + k], 0));
const scalar = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function refuseDepth({ depth, metres, heights }, isTexture, isBuffer) {
  if (depth && !isTexture(depth))
    throw new Error("sandglass: receiveByDepth takes a texture as depth. Of a render target pass its depthTexture.");
  if (depth && !isBuffer(depth) && !metres)
    throw new Error(
      "sandglass: receiveByDepth needs what the numbers of a depth image are times to give metres. Pass { metres }.",
    );
  if (!heights) return;
  const [columns, rows] = heights.cells ?? [];
  const given = heights.heights?.length ?? "no";
  if (!(given === columns * rows))
    throw new Error(`sandglass: receiveByDepth needs a height for each of ${columns} x ${rows} cells, not ${given}.`);
  if (!["corner", "along", "across", "up"].every((name) => heights[name]?.length === 3))
    throw new Error(
      "sandglass: receiveByDepth needs corner, along, across and up of heights, as sandglass_heights has them.",
    );
}

export class DepthView {
  // `isTexture`: of the engine; `isBuffer`: what a camera has drawn as its depth buffer.
  constructor(isTexture, isBuffer = () => false) {
    Object.assign(this, { isTexture, isBuffer, options: { fromView: k_identity }, known: null });
  }
  // What is not given stays as it was. Says what was given.
  set(options) {
    const given = checked("receiveByDepth", options, k_kinds);
    const next = { ...this.options, ...given };
    refuseDepth(next, this.isTexture, this.isBuffer);
    this.options = next;
    if (given.heights === undefined) return given;
    const { heights } = next; // views of a module's memory end when it grows
    const highest = heights?.heights.reduce((most, x) => Math.max(most, x), 0);
    this.known = heights && { highest, matrix: toHeights(heights) };
    return given;
  }
  // `camera`: the depth's own, or null, and `view` that which draws, each { view, projection, fromZero, reversed }; `flip`: the texture's
  // lower row is its first.
  values(view, camera, flip, floor, inverse) {
    const { depth, metres, fromView } = this.options;
    let to = flip ? product(k_flipped, fromView) : fromView;
    let from = to;
    if (camera) {
      to = product(product(to, k_picture), product(camera.projection, camera.view));
      [to[2], to[6], to[10], to[14]] = [0, 0, 0, 1];
      from = inverse(to);
    }
    const buffer = depth && this.isBuffer(depth) ? bufferDepth(camera ?? view) : null;
    return {
      sandglass_to_depth: to,
      sandglass_from_depth: from,
      sandglass_to_heights: this.known?.matrix ?? toHeights({ ...k_no_heights, corner: [1, floor, 1] }),
      sandglass_metres: buffer?.metres ?? [metres ?? 1, 0, 0, 1],
      sandglass_known: [depth ? (buffer?.farthest ?? k_farthest) : 0, camera ? 1 : 0, this.known?.highest ?? 0, 0],
    };
  }
}

// Without heights no place is on their texture.
const k_no_heights = { along: [1e9, 0, 0], across: [0, 0, 1e9], up: [0, 1, 0] };

function toHeights({ corner, along, across, up }) {
  const rows = [along, up, across].map((axis, i) => Array.from(axis, (x) => (i === 1 ? x : x / scalar(axis, axis))));
  return [
    ...[0, 1, 2].flatMap((k) => [...rows.map((row) => row[k]), 0]),
    ...rows.map((row) => -scalar(row, corner)),
    1,
  ];
}

// How a camera's depth buffer gives metres along its axis, and those at which nothing is drawn.
function bufferDepth({ projection, fromZero, reversed }) {
  const metres = [0, projection[14], fromZero ? 1 : 2, fromZero ? projection[10] : projection[10] - 1];
  return { metres, farthest: (k_nearly * projection[14]) / ((reversed ? 0 : 1) + projection[10]) };
}
