// The field of a mesh, which sand lies on, and the matrix of its pose.
import { constants } from "./sandglass.mjs";

const k_field_nodes = 4e6; // at most: a large model gets a coarser field
const k_band = 4; // spacings around the mesh that the field knows

// Column-major, of a pose.
export function matrixOf([px, py, pz], [x, y, z, w]) {
  const right = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0];
  const up = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0];
  const back = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0];
  return [...right, ...up, ...back, px, py, pz, 1];
}

// A mesh as casts and reliefs take it: its number, and what addModel keeps of it.
export function castMesh(sand, mesh, [version, { positions, vertices, indices, count, position, rotation }]) {
  sand.sandglass_cast_mesh_default(mesh);
  const world_from_mesh = matrixOf(position, rotation);
  mesh.set({ positions, vertex_count: vertices, indices, triangle_count: count, version, world_from_mesh });
}

// One of the library's objects, of its description's defaults and `fields`, or what they give of the description.
export function made(sand, name, fields = {}, ...more) {
  const desc = sand.make(`${name}_desc`);
  try {
    sand[`${name}_desc_default`](desc, ...more);
    desc.set(typeof fields === "function" ? fields(desc) : fields);
    return sand.create(name, desc);
  } finally {
    sand.free(desc);
  }
}

// What `use` gives of a mesh in the module's memory. `keep` marks what is given back afterwards, also where the library
// refuses.
export function withMesh(sand, vertices, indices, use) {
  const kept = [];
  const keep = (block) => {
    kept.push(block);
    return block;
  };
  try {
    const mesh = sand.make("sandglass_mesh", {
      vertices: keep(sand.put(vertices)),
      vertex_count: vertices.length / 3,
      indices: keep(sand.put(indices)),
      triangle_count: indices.length / 3,
    });
    return use(keep(mesh), keep);
  } finally {
    for (const block of kept) sand.free(block);
  }
}

// A mesh as the library's arrays, and its longest side. Refuses what is none.
export function checkedMesh({ positions: given, indices: corners }) {
  const positions = given instanceof Float32Array ? given : Float32Array.from(given ?? []);
  const indices = corners instanceof Uint32Array ? corners : Uint32Array.from(corners ?? []);
  const vertices = positions.length / 3;
  if (indices.length === 0)
    throw new Error("sandglass: the model has no triangles. Add an object that has a mesh, which is not hidden.");
  if (!Number.isInteger(vertices) || indices.length % 3 !== 0)
    throw new Error("sandglass: a model has three numbers a vertex and three indices a triangle. Pass triangles.");
  const last = indices.reduce((most, i) => Math.max(most, i), 0);
  if (last >= vertices)
    throw new Error(`sandglass: a model's indices name vertex ${last} of ${vertices}. Pass indices of its positions.`);
  const low = [Infinity, Infinity, Infinity];
  const high = low.map((x) => -x);
  positions.forEach((x, i) => {
    low[i % 3] = Math.min(low[i % 3], x);
    high[i % 3] = Math.max(high[i % 3], x);
  });
  const side = Math.max(...high.map((x, k) => x - low[k]));
  if (!Number.isFinite(side)) throw new Error("sandglass: a vertex of the model is not finite. Check its positions.");
  return { positions, indices, vertices, count: indices.length / 3, side };
}

// The bytes of the field, for another instance's memory too. `spacing`: of its nodes, metres.
export function fieldOf(sand, { positions, indices }, spacing) {
  return withMesh(sand, positions, indices, (mesh, keep) => {
    const inside = keep(sand.create("sandglass_mesh_inside", mesh, constants.SANDGLASS_INSIDE_WINDING));
    const desc = keep(
      sand.make("sandglass_field_desc", {
        solid: constants.SANDGLASS_SOLID_INSIDE,
        mesh,
        inside: sand.pointer("sandglass_mesh_inside_test"),
        inside_user: inside,
      }),
    );
    const { bounds_min: low, bounds_max: high } = desc;
    sand.sandglass_mesh_bounds(mesh, low, high);
    const volume = [...high].reduce((product, top, k) => product * (top - low[k] + 2 * k_band * spacing), 1);
    desc.spacing = Math.max(spacing, Math.cbrt(volume / k_field_nodes));
    desc.band = k_band * desc.spacing;
    for (let k = 0; k < 3; ++k) {
      low[k] -= desc.band;
      high[k] += desc.band;
    }
    const size = keep(sand.allocate(8));
    sand.sandglass_field_bytes(desc, size);
    const bytes = Number(sand.view().getBigUint64(size, true));
    return sand.bytes(keep(sand.create("sandglass_field", desc)), bytes).slice();
  });
}
