// What stands before the camera: an hourglass, or a table with a chair and a funnel. Each has its own sand; of both only the
// one that is shown moves.
import { constants } from "./sandglass.mjs";
import { SandScene, unpacked } from "./scene.mjs";
import { made, matrixOf } from "./mesh_field.mjs";
import { k_glass_particles, k_glass_radius } from "./hourglass.mjs";
import { k_scene } from "./data.mjs";

// Metres from the middle, of glass walls that are passed once the table was tipped, so that no sand slides away for ever.
const k_wall = 0.62;
const k_wall_places = [
  { position: [-k_wall, 0, 0], rotation: [0, 0, -1, 1] },
  { position: [k_wall, 0, 0], rotation: [0, 0, 1, 1] },
  { position: [0, 0, -k_wall], rotation: [1, 0, 0, 1] },
  { position: [0, 0, k_wall], rotation: [-1, 0, 0, 1] },
];
export const k_walls = k_wall_places.map((place) => {
  return { shape: constants.SANDGLASS_SHAPE_HALF_SPACE, ...place, size: [1, 1, 1] };
});
export const k_objects = 4; // that are put on the table, at most
export const k_object_triangles = 100000; // of all of them
export const k_casts = { shadow: false, collide: false }; // of a model: what is shown casts, and fields are the page's

const k_funnel = [0.86, 0.62, 0.28]; // albedos
const k_chair = [0.17, 0.3, 0.43];
const k_wood = [0.16, 0.075, 0.035];
const k_glass_friction = 0.3;
export const k_glass_min = 500; // particles, on a slow device
const k_glass_ms = 16; // of all work of a frame that is worth it; levels of quality save half of it
const k_trials = 8; // frames at most, before the first picture is drawn
const k_trial_ms = 120; // how long others follow

export function newTableScene(sand) {
  const more = 2 + k_walls.length + k_objects; // and the finger, and what is real
  const changes = { emitter_capacity: 2, collider_capacity: k_scene.colliders.length + more };
  return new SandScene(sand, k_scene, { clock: true, colliders: more, changes });
}

const newSkin = (sand, { desc }, capped) => made(sand, "sandglass_skin", { capped }, desc.granular);

// With its funnel and what the scene's file puts there.
/** @param {import("./stage.mjs").Stage} stage */
export function makeTable(sand, stage, painter, { funnel }) {
  const scene = newTableScene(sand);
  const standing = [];
  const drawn = [];
  painter.funnel = painter.item(funnel.vertices, funnel.indices, null, k_funnel, funnel.normals);
  stage.reserve(k_object_triangles);
  for (const { field, position, rotation } of k_scene.colliders) {
    if (!field) continue;
    const vertices = unpacked(field.vertices, Float32Array);
    const indices = unpacked(field.indices, Uint32Array);
    drawn.push(painter.item(vertices, indices, matrixOf(position, rotation), k_chair));
    standing.push(stage.addModel({ positions: vertices, indices, position, rotation }, k_casts));
  }
  return { scene, standing, drawn, skin: newSkin(sand, scene, 0) };
}

function glassScene(sand, made, particles) {
  const still = { position: [0, 0, 0], rotation: [0, 0, 0, 1], size: [1, 1, 1] };
  const granular = {
    ...k_scene.granular,
    particle_radius: k_glass_radius,
    particle_capacity: k_glass_particles,
    grain_radius: 0,
    substep_max: 0,
    substep_min: 0,
    collider_capacity: 2,
    static_friction: k_glass_friction,
    kinetic_friction: k_glass_friction,
  };
  const colliders = [
    { shape: constants.SANDGLASS_SHAPE_HALF_SPACE, ...still },
    { shape: constants.SANDGLASS_SHAPE_FIELD, ...still, field: { made } },
  ];
  const { gravity, frame_step } = k_scene;
  const file = { name: "hourglass", gravity, frame_step, emitters: [], particles, granular, colliders };
  return new SandScene(sand, file, { clock: true });
}

// The hourglass stands still with all its sand below until it is turned over. `pose`: how it stands. Then what hourglassMade gives.
/** @param {import("./stage.mjs").Stage} stage */
export function makeGlass(sand, stage, painter, pose, { field, below, wood, glass }) {
  const scene = glassScene(sand, field, below.subarray(0, 3 * k_glass_min));
  const model = matrixOf(pose.position, pose.rotation);
  return {
    scene,
    below,
    full: below.length / 3,
    skin: newSkin(sand, scene, 1),
    drawn: [painter.item(wood.vertices, wood.indices, model, k_wood)],
    standing: [stage.addModel({ positions: wood.vertices, indices: wood.indices, ...pose }, k_casts)],
    glass: { ...painter.mesh(glass.vertices, glass.indices, glass.normals), model },
  };
}

// Few frames at rest tell how many particles this device simulates in time. `settle` runs one and gives its milliseconds.
export function fitting(full, settle) {
  const since = performance.now();
  let fits = 0;
  for (let i = 0; i < k_trials; ++i) {
    if (i > 0 && (fits >= full || performance.now() - since >= k_trial_ms)) break;
    fits = Math.max(fits, (k_glass_min * k_glass_ms) / settle());
  }
  return fits;
}
