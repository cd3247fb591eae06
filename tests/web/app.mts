// Pours sand and prints where it lies: what a web app does first.
import { load, constants } from "sandglass";

const sand = await load();
if (Math.floor(sand.sandglass_version() / 1000) !== constants.SANDGLASS_VERSION_MINOR)
  throw new Error("another version");
const desc = sand.make("sandglass_scene_desc");
sand.sandglass_scene_desc_default(desc);
desc.granular.set({ particle_capacity: 400, grain_capacity: 3200, emitter_capacity: 1, collider_capacity: 1 });
const told = [""];
desc.log.write = sand.pointer((user, sentence) => told.push(sand.text(sentence) ?? ""), "vii");
const scene = sand.create("sandglass_scene", desc);

const floor = sand.make("sandglass_collider", { shape: constants.SANDGLASS_SHAPE_HALF_SPACE, rotation: [0, 0, 0, 1] });
const nozzle = sand.make("sandglass_emitter", {
  position: [0, 0.4, 0],
  rotation: [0, 0, 0, 1],
  radius: 0.03,
  speed: 1,
  grains_per_particle: 8,
});
const grains = sand.allocate(3200 * 16);
const input = sand.make("sandglass_frame_input");
sand.sandglass_frame_input_default(input);
input.set({
  time_step: 1 / 60,
  budget_ns: 1e9,
  colliders: floor.address,
  collider_count: 1,
  emitters: nozzle.address,
  emitter_count: 1,
  grains,
  grain_capacity: 3200,
});
const report = sand.make("sandglass_frame_report");
for (let frame = 0; frame < 90; ++frame) sand.sandglass_scene_frame(scene, input, report);

let lowest = Infinity;
let highest = -Infinity;
const floats = sand.floats(grains, 4 * report.sand.grain_numbers);
for (let i = 1; i < floats.length; i += 4) {
  lowest = Math.min(lowest, floats[i]);
  highest = Math.max(highest, floats[i]);
}
console.log(
  `${report.sand.grains} grains of ${report.sand.particles} particles from ${lowest.toFixed(3)} to ${highest.toFixed(3)} m`,
);
if (report.sand.grains < 1000 || report.sand.grains !== 8 * report.sand.particles)
  throw new Error("the nozzle does not pour");
if (lowest < 0 || highest > 0.41) throw new Error("the sand is not between floor and nozzle");
// 400 particles are soon poured; what there is no room for is counted and logged.
if (report.sand.denied_particles === 0 || !told.some((sentence) => sentence.includes("raise particle_capacity")))
  throw new Error(`the log says ${told}`);

// What C refuses is thrown, in the library's words; nothing is left allocated.
let refused = "";
desc.gravity.set([NaN, 0, 0]);
try {
  sand.create("sandglass_scene", desc);
} catch (error) {
  refused = String(error);
}
if (!refused.includes("gravity")) throw new Error(`refused with: ${refused}`);
// A JavaScript function as a C callback: a ball in a box of one metre.
const distance = sand.pointer((user, at) => Math.hypot(...sand.floats(at, 3).map((x) => x - 0.5)) - 0.25, "fii");
const field = sand.create(
  "sandglass_field",
  sand.make("sandglass_field_desc", { bounds_max: [1, 1, 1], spacing: 0.125, distance }),
);
const middle = sand.put(new Float32Array([0.5, 0.5, 0.5]));
if (sand.sandglass_field_distance(field, middle, 0) !== -0.25) throw new Error("the field differs");
const memory = sand.memory.buffer.byteLength;
for (let i = 0; i < 50; ++i) {
  desc.gravity.set([0, -9.81, 0]);
  sand.destroy(sand.create("sandglass_scene", desc));
}
if (sand.memory.buffer.byteLength !== memory) throw new Error("memory grows");
// Memory grows after the array was looked up, and the write arrives. The control: a view that was held has ended.
const image = sand.make("sandglass_camera_image");
const held = sand.floats(grains, 4);
const view = sand.view();
image.planes[0] = sand.put(new Uint8Array(96 << 20));
if (image.planes[0] === 0 || sand.view() === view || held.length !== 0)
  throw new Error("a write is lost when memory grows");
let beyond = false;
try {
  image.planes[3] = 1;
} catch {
  beyond = true;
}
if (!beyond) throw new Error("an array takes an item beyond its end");
// With threads: the module beside, and a pool for the scene.
const pooled = await load(undefined, { threads: 2 });
const shared = pooled.make("sandglass_scene_desc");
pooled.sandglass_scene_desc_default(shared);
shared.parallel.set(pooled.parallel);
if (pooled.threads !== 2 || shared.parallel.run === 0 || sand.parallel.run !== 0) throw new Error("there is no pool");
console.log("done");
