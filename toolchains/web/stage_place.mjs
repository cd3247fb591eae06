// The real place of a stage: meshes and depth images, gathered as heights over its floor (relief.h); and what is closed and stands
// there as it is.
import { constants } from "./sandglass.mjs";
import { castMesh, made } from "./mesh_field.mjs";
import { checked, k_depth_options } from "./options.mjs";

const k_place_meshes = 256; // that are open
const k_place_triangles = 1e6; // of one
const k_cell = { most: 256, least: 16, finest: 0.01, coarsest: 0.05 }; // of the map: how many along a side, and metres
const k_relief_id = 2 ** 31; // as a collider; models have numbers from 1 on
const k_ceiling = 0.5; // metres above the floor: of relief.h
const k_weld = 1e-5; // of a mesh's longest side: corners that are one
const k_depth_bytes = [
  [Uint16Array, constants.SANDGLASS_DEPTH_U16],
  [Float32Array, constants.SANDGLASS_DEPTH_F32],
];

// Whether each edge of a mesh is there as often in the one direction as in the other, and it holds a volume: by a sum that is then 0,
// of numbers made of the edges' ends, modulo 2^32. A scanned room is open, or it is hollow, and turned inwards.
export function isSolid({ positions, indices, side }) {
  const numbers = new Uint32Array(positions.length / 3);
  for (let i = 0; i < numbers.length; ++i)
    for (let k = 0; k < 3; ++k)
      numbers[i] = mixed(numbers[i] ^ Math.round(positions[3 * i + k] / (k_weld * side || 1)), 0x9e3779b1 + k);
  let open = 0;
  let volume = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [indices[i], indices[i + 1], indices[i + 2]];
    const [na, nb, nc] = [numbers[a], numbers[b], numbers[c]];
    if (na === nb || nb === nc || nc === na) continue; // without an area
    for (const [from, to] of [
      [na, nb],
      [nb, nc],
      [nc, na],
    ])
      open = (open + mixed(from, to) - mixed(to, from)) | 0;
    const p = (corner, k) => positions[3 * corner + k] - positions[k];
    volume +=
      p(a, 0) * (p(b, 1) * p(c, 2) - p(b, 2) * p(c, 1)) +
      p(a, 1) * (p(b, 2) * p(c, 0) - p(b, 0) * p(c, 2)) +
      p(a, 2) * (p(b, 0) * p(c, 1) - p(b, 1) * p(c, 0));
  }
  return open === 0 && volume > 0;
}
function mixed(a, b) {
  let x = Math.imul(a ^ (b >>> 15), 0x85ebca6b) ^ Math.imul(b ^ (a >>> 13), 0xc2b2ae35);
  x = Math.imul(x ^ (x >>> 16), 0x27d4eb2f);
  return (x ^ (x >>> 15)) >>> 0;
}

export class StagePlace {
  #sand;
  #area; // { origin, half } of the floor
  #relief = 0;
  #meshes;
  #heights = 0;
  #image;
  #pixels = { block: 0, bytes: 0 };
  #images = 0;
  #new = false; // an image that no frame has seen

  constructor(sand, area) {
    this.#sand = sand;
    this.#area = area;
  }
  get relief() {
    return this.#relief;
  }
  #needRelief() {
    if (this.#relief) return;
    const sand = this.#sand;
    const { origin, half } = this.#area;
    const { most, least, finest, coarsest } = k_cell;
    const cell = Math.min(coarsest, Math.max(finest, (2 * half) / most));
    const cells = Math.min(most, Math.max(least, Math.round((2 * half) / cell)));
    const relief = made(sand, "sandglass_relief", {
      cells: [cells, cells],
      cell,
      mesh_capacity: k_place_meshes,
      ceiling: k_ceiling,
    });
    const pose = sand.put(Float32Array.of(...origin, 0, 0, 0, 1));
    try {
      sand.sandglass_relief_set_plane(relief, pose, pose + 12);
    } catch (error) {
      sand.destroy(relief);
      throw error;
    } finally {
      sand.free(pose);
    }
    this.#meshes = sand.array("sandglass_cast_mesh", k_place_meshes);
    this.#heights = sand.make("sandglass_heights");
    this.#image = sand.make("sandglass_depth_image");
    sand.sandglass_depth_image_default(this.#image);
    this.#relief = relief;
  }

  // Before a mesh is taken: how many there are with it. Gives up to which height above the floor it has to receive shadows.
  makeRoom(count, { positions, indices }, { position, rotation }, solid) {
    const [most, all] = [k_place_triangles, indices.length / 3];
    if (all > most)
      throw new Error(
        `sandglass: a place has ${most} triangles at most, and this has ${all}. Simplify it, or add its parts.`,
      );
    if (count > k_place_meshes)
      throw new Error(`sandglass: a stage holds ${k_place_meshes} open meshes of places. Remove one, or join them.`);
    if (!solid) this.#needRelief();
    const [qx, qy, qz, qw] = rotation;
    const scale = 2 / (qx * qx + qy * qy + qz * qz + qw * qw);
    const up = [scale * (qx * qy + qz * qw), 1 - scale * (qx * qx + qz * qz), scale * (qy * qz - qx * qw)];
    let top = 0;
    for (let i = 0; i < positions.length; i += 3)
      top = Math.max(top, up[0] * positions[i] + up[1] * positions[i + 1] + up[2] * positions[i + 2]);
    top += position[1] - this.#area.origin[1];
    return solid ? top : Math.min(top, k_ceiling);
  }
  // The open ones: pairs of a number and the mesh.
  setMeshes(places) {
    if (!this.#relief) return;
    places.forEach((place, i) => castMesh(this.#sand, this.#meshes[i], place));
    this.#sand.sandglass_relief_set_meshes(this.#relief, this.#meshes, places.length);
  }

  // A depth image: 16 bits or floats a pixel, the upper row first. One that is as the one before is none.
  see(given) {
    const image = checked("seeDepth", given, k_depth_options, {
      needed: ["data", "width", "height", "focal", "centre", "position", "orientation"],
      reach: 1e6,
    });
    const { data, width, height, toMetres = 1, focal, centre, position, orientation } = image;
    const kind = k_depth_bytes.find(([Kind]) => data instanceof Kind);
    if (!kind || data.length !== width * height)
      throw new Error(
        `sandglass: seeDepth: data must be ${width} x ${height} numbers in a Uint16Array or a Float32Array, the upper row first.`,
      );
    const within = (x, low, high) => x >= low && x <= high;
    const sides = [width, height];
    if (
      !sides.every((side, k) => Number.isInteger(side) && within(side, 2, 16384) && within(centre[k], 0, side - 1)) ||
      !focal.every((x) => within(x, 1, 1e6)) ||
      !within(toMetres, 1e-6, 1e3)
    )
      throw new Error(
        "sandglass: seeDepth: width, height, focal, centre or toMetres is out of range. Pass those of the depth image, in its own pixels.",
      );
    this.#needRelief();
    if (!this.#keep(new Uint8Array(data.buffer, data.byteOffset, data.byteLength))) return;
    this.#image.set({
      format: kind[1],
      width,
      height,
      depth: this.#pixels.block,
      stride: width * data.BYTES_PER_ELEMENT,
      to_metres: toMetres,
      focal_x: focal[0],
      focal_y: focal[1],
      centre_x: centre[0],
      centre_y: centre[1],
      position,
      orientation,
      timestamp_ns: ++this.#images,
    });
    this.#new = true;
  }
  // Says whether the bytes are others than before.
  #keep(bytes) {
    const sand = this.#sand;
    if (this.#pixels.bytes !== bytes.length) {
      sand.free(this.#pixels.block);
      this.#pixels = { block: sand.put(bytes), bytes: bytes.length };
      return true;
    }
    const kept = sand.bytes(this.#pixels.block, bytes.length);
    if (bytes.every((byte, i) => byte === kept[i])) return false;
    kept.set(bytes);
    return true;
  }

  // Fields of sandglass_frame_input of the next frame.
  fields() {
    const depth = this.#new ? this.#image.address : 0;
    this.#new = false;
    return { relief: this.#relief, depth };
  }
  forget() {
    if (this.#relief) this.#sand.sandglass_relief_reset(this.#relief);
  }
  // As shadows of sand fall on them; 0: there are none.
  get heights() {
    if (this.#relief) this.#sand.sandglass_relief_get_heights(this.#relief, this.#heights);
    return this.#heights;
  }
  // As colliders of sand.
  get bodies() {
    const relief = this.#relief;
    const { SANDGLASS_SHAPE_RELIEF: shape } = constants;
    return relief ? [{ shape, position: this.#area.origin, relief, id: k_relief_id }] : [];
  }
}
