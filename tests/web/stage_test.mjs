// Models that stand so far apart that their common shadow is coarse: that is said, once; of those that stand near it is not. For
// what receives above the floor there are layers, of which a shadow is in those below its model.
// node stage_test.mjs NPM_FOLDER
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
const { Stage } = await import(pathToFileURL(`${process.argv[2]}/stage.mjs`));

const side = 0.1;
const positions = Float32Array.from({ length: 24 }, (_, i) => (((i / 3) >> (i % 3)) & 1) * side);
const indices = Uint32Array.from([
  0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3,
]);
const said = [];
console.warn = (message) => said.push(message);
for (const [away, times] of [
  [0.5, 0],
  [6, 1],
]) {
  const stage = await Stage.create({});
  const [first] = [0, away].map((x) =>
    stage.addModel({ positions, indices, position: [x, 0, 0], rotation: [0, 0, 0, 1] }),
  );
  let textures = 0;
  said.length = 0;
  for (let i = 0; i < 200 && textures < 2; ++i) {
    if (stage.frame(1 / 60).textures.shadow) {
      ++textures;
      stage.move(first, [0, 0.01, 0], [0, 0, 0, 1]);
    }
  }
  assert.equal(textures, 2);
  assert.equal(said.length, times, `${away} m apart: ${said}`);
  if (times) assert.match(said[0], /texels of \d+\.\d cm/);
}
console.log("a coarse shadow is said once");

for (const height of [undefined, 0.6]) {
  const stage = await Stage.create({ height });
  stage.addModel({ positions, indices, position: [0, 0.25, 0], rotation: [0, 0, 0, 1] });
  let drawn = stage.frame(1 / 60);
  for (let i = 0; i < 200 && !drawn.textures.shadow; ++i) drawn = stage.frame(1 / 60);
  const { side, bytes } = drawn.textures.shadow;
  const layers = height ? 4 : 1;
  assert.equal(bytes.length, layers * side ** 2);
  assert.deepEqual(drawn.layers, height ? [4, 3 / height] : [1, 0]);
  const [x, y, z] = drawn.light.toLight;
  [x / y, z / y].forEach((along, k) => assert.ok(Math.abs(drawn.slide[k] - along) < 0.1, `${drawn.slide} ${along}`));
  assert.equal(drawn.slide[2], 0.5 / side);
  const dark = Array.from({ length: layers }, (_, k) =>
    bytes.subarray(k * side ** 2, (k + 1) * side ** 2).some((byte) => byte > 200),
  );
  assert.deepEqual(dark, height ? [true, true, false, false] : [true]); // at 0, 0.2, 0.4 and 0.6 m, of a box up to 0.35 m
  stage.end();
}
console.log("a shadow has layers, up to its model");

// ---- The real place

const k_radius = 0.006;
const k_still = { position: [0, 0, 0], rotation: [0, 0, 0, 1] };
// A table with its winding outwards, its feet at the origin.
const table = (indices) => ({
  positions: positions.map((x, i) => (i % 3 === 1 ? x : 3 * x - 0.15)),
  indices: indices.map((_, i) => indices[i - (i % 3) + [0, 2, 1][i % 3]]),
});
// A stage whose frames tell what the library saw, and where and how fast its particles are.
async function watched(options) {
  const { sand } = await Stage.create({});
  const seen = {};
  const frame = sand.sandglass_scene_frame;
  sand.sandglass_scene_frame = (scene, input, report) => {
    frame(scene, input, report);
    const { ignored_colliders: ignored, particle_numbers: count } = report.sand;
    Object.assign(seen, { scene, ignored, colliders: input.collider_count, count });
  };
  const stage = new Stage(sand, { budget: 1000, ...options });
  const particles = () => {
    const blocks = [0, 1].map(() => sand.allocate(12 * seen.count));
    sand.sandglass_scene_particles(seen.scene, blocks[0], blocks[1]);
    const [at, ways] = blocks.map((block) => sand.floats(block, 3 * seen.count).slice());
    for (const block of blocks) sand.free(block);
    return Array.from({ length: seen.count }, (_, i) => ({
      y: at[3 * i + 1],
      speed: Math.hypot(...ways.slice(3 * i, 3 * i + 3)),
    }));
  };
  return { stage, seen, particles };
}
const run = (stage, frames) => {
  for (let i = 0; i < frames; ++i) stage.frame(1 / 60);
};
const lowest = (particles) => particles().reduce((low, { y }) => Math.min(low, y), Infinity);

// Sand lies on a table, closed or open, a particle's radius above it; on the floor where there is none, and where it is taken away.
for (const [name, mesh] of [
  ["closed", table(indices)],
  ["open", table(indices.slice(3))],
  ["none", null],
]) {
  const { stage, particles } = await watched();
  stage.createSand({ particles: 300, radius: k_radius });
  const place = mesh && stage.addPlace({ ...mesh, ...k_still });
  await stage.fields;
  stage.pour({ position: [0, 0.3, 0] });
  run(stage, 120);
  const height = mesh ? side : 0;
  assert.ok(Math.abs(lowest(particles) - height - k_radius) < 0.002, `${name}: ${lowest(particles)}`);
  assert.equal(stage.relief !== 0, name === "open");
  assert.equal(stage.frame(0).layers[0], mesh ? 4 : 1); // what stands there receives shadows
  if (!place) continue;
  stage.pour();
  stage.move(place, [2, 0, 0], [0, 0, 0, 1]);
  run(stage, 120);
  assert.ok(Math.abs(lowest(particles) - k_radius) < 0.002, `${name}, moved: ${lowest(particles)}`);
  stage.move(place, ...Object.values(k_still));
  stage.remove(place);
  run(stage, 30);
  assert.ok(lowest(particles) < 0.01, `${name}, removed`);
}
const { stage: told } = await watched({ height: 0.3 }); // what an app has said stays
told.addPlace({ ...table(indices), ...k_still, position: [0, 0.4, 0] });
assert.deepEqual(told.frame(0).layers, [4, 10]);
console.log("sand lies on places, and falls without them");

// The shadow of sand that lies on an open table, in a sun of 45 degrees, is nearer by the table's height than on the floor, where it
// is beside a solid one, of which no heights are known. There columns of sand may begin too low, by bricks of the skin (skin.cpp).
async function shadowOnTable(mesh) {
  const { stage } = await watched({ half: 0.32 });
  stage.createSand({ particles: 300, radius: k_radius });
  stage.addPlace({ ...mesh, ...k_still });
  await stage.fields;
  stage.pour({ position: [0, 0.3, 0] });
  run(stage, 400); // until the light is as it stays
  stage.shade([1, 1, 0], [...stage.fadedLight.ambient_cells], 0.1);
  let pile;
  for (let i = 0; i < 200; ++i) pile = stage.frame(1 / 60).textures.pile?.bytes.slice() ?? pile;
  const texels = Math.sqrt(pile.length);
  const [sum, moment] = pile.reduce(([s, m], byte, i) => [s + byte, m + byte * ((i % texels) + 0.5)], [0, 0]);
  return (0.64 * moment) / sum / texels - 0.32; // metres along x
}
const [on_table, through] = [await shadowOnTable(table(indices.slice(3))), await shadowOnTable(table(indices))];
assert.ok(on_table > -0.04 && Math.abs(on_table - through - side) < 0.03, `${on_table}, ${through}`);
console.log("the shadow of sand falls on the table that it lies on");

// A hand that lies in sand: 25 joints, 1 cm apart along its fingers.
const hand = (x, y) =>
  Array.from({ length: 25 }, (_, i) => ({
    position: [x + 0.015 * (i > 0 ? Math.floor((i - 1) / 5) - 2 : 0), y, i > 0 ? 0.02 + 0.01 * ((i - 1) % 5) : 0],
    radius: 0.008,
  }));
async function pile() {
  const all = await watched();
  all.stage.createSand({ particles: 1500, radius: k_radius });
  all.stage.pour({ position: [0, 0.3, 0.03] });
  run(all.stage, 240);
  all.stage.pour();
  run(all.stage, 60);
  all.fastest = (frames) => {
    let most = 0;
    for (let i = 0; i < frames; ++i) {
      all.stage.frame(1 / 60);
      most = all.particles().reduce((a, { speed }) => Math.max(a, speed), most);
    }
    return most;
  };
  return all;
}
const k_gentle = 0.225 * Math.sqrt(2 * 9.81 * k_radius); // m/s: as what appears in sand is left (sand.h)
const { stage, seen, fastest } = await pile();
stage.setHands(hand(0, 0.25), null); // above the sand
const resting = fastest(2);
assert.equal(seen.colliders, 1 + 24);
stage.setHands(null, null);
run(stage, 2);
assert.equal(seen.colliders, 1);
stage.setHands(hand(0, 0.03), hand(0.02, 0.02)); // in it, 0.22 m away after 3 frames: 4 m/s
const found = fastest(5);
assert.deepEqual([seen.colliders, seen.ignored], [1 + 48, 0]);
const most = resting + k_gentle + 9.81 * (5 / 60); // what falls meanwhile
assert.ok(found < most, `${found} m/s, at rest ${resting}`);
stage.push(...Array.from({ length: 31 }, (_, i) => ({ position: [0.5, i, 0], radius: 0.01 })));
run(stage, 1);
assert.deepEqual([seen.colliders, seen.ignored], [1 + 48 + 31, 0]);
const control = await pile();
control.stage.push(...hand(0, 0.03).map((joint) => ({ ...joint, velocity: [0, -4, 0] })));
const thrown = control.fastest(5);
assert.ok(thrown > most, `balls of that velocity throw sand at ${thrown} m/s`);
console.log(`hands come back at ${found.toFixed(2)} m/s, balls that jump at ${thrown.toFixed(2)}`);

// Depth of a table before a plane, straight from above, in which rows are noisy by 1 mm. What a pixel shows is z of its ray.
const k_depth = { width: 160, height: 120, focal: [140, 140], centre: [79.5, 59.5], toMetres: 0.001 };
const k_above = { position: [0.02, 0.6, 0], orientation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2] };
const seenFrom = ({ width, height, focal, centre }, { position }, noise) =>
  Uint16Array.from({ length: width * height }, (_, i) => {
    const [x, y] = [((i % width) - centre[0]) / focal[0], (Math.floor(i / width) - centre[1]) / focal[1]];
    const depth = position[1] - side;
    const hit = Math.abs(position[0] + x * depth) < 0.15 && Math.abs(position[2] + y * depth) < 0.15;
    return Math.round(1000 * (hit ? depth : position[1])) + ((i * 7 + noise) % 3) - 1;
  });
for (const [name, images, pose, height] of [
  ["moving images", 30, k_above, side],
  ["no image", 0, k_above, 0],
  ["one image again and again", -30, k_above, 0], // it is one look
  ["a camera that stands elsewhere", 30, { ...k_above, position: [0.42, 0.6, 0] }, 0],
]) {
  const { stage, particles } = await watched();
  stage.createSand({ particles: 200, radius: k_radius });
  for (let i = 0; i < Math.abs(images); ++i) {
    stage.seeDepth({ ...k_depth, ...pose, data: seenFrom(k_depth, k_above, images > 0 ? i : 0) });
    stage.frame(1 / 60);
  }
  stage.pour({ position: [0, 0.3, 0] });
  run(stage, 90);
  assert.ok(Math.abs(lowest(particles) - height - k_radius) < 0.004, `${name}: ${lowest(particles)}`);
}
console.log("sand lies on what depth images show");
