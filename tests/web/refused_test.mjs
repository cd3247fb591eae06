// What a stage refuses is refused in a sentence that says what to do, and nothing has changed: its sand, its shadows and the
// module's memory are as before, and frames go on.
// node refused_test.mjs NPM_FOLDER
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
const { Stage } = await import(pathToFileURL(`${process.argv[2]}/stage.mjs`));

const k_here = { position: [0.3, 0.1, 0], rotation: [0, 0, 0, 1] };
const k_held = 1 << 16; // bytes that an app holds
const k_tetrahedron = {
  positions: [0, 0, 0, 0.2, 0, 0, 0, 0.2, 0, 0, 0, 0.2],
  indices: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
};
const turned = (rotation) => ({ ...k_tetrahedron, ...k_here, rotation });
const many = (count) => ({ ...k_tetrahedron, indices: Uint32Array.from({ length: 3 * count }, (_, i) => i % 3) });
const bytes = (count, Kind = Uint8Array) => ({ data: new Kind(count).fill(99), width: 8, height: 6 });
const rows = (count, make) => Array.from({ length: count }, (_, i) => make(i));
const joints = (count, more = {}) => rows(count, () => ({ position: [0, 0.2, 0], radius: 0.01, ...more }));
const depth = (more) => ({
  ...{ data: new Float32Array(48), width: 8, height: 6, focal: [9, 9], centre: [4, 3] },
  ...{ position: [0, 1, 0], orientation: [0, 0, 0, 1], ...more },
});
const ball = { position: [0, 0.2, 0], radius: 0.1 };

const stage = await Stage.create();
stage.createSand({ particles: 300 });
const model = stage.addModel({ ...k_tetrahedron, ...k_here });
stage.pour({ position: [0, 0.3, 0] });
await stage.fields;
let drawn;
const frames = (count) => {
  for (let i = 0; i < count; ++i) drawn = stage.frame(1 / 60);
  return drawn;
};
assert.equal(frames(40).particles, 300);
stage.pour();
assert.deepEqual([drawn.shadowOpacity, drawn.fieldsLeft], [1, 0]);
const held = stage.sand.allocate(k_held);
stage.sand.bytes(held, k_held).fill(7);

const refused = [
  [() => stage.sand.allocate(undefined), /whole number of bytes, not undefined\. Pass/],
  [() => stage.sand.allocate(2 ** 32 + 8), /there is no memory for 4294967304 bytes\. Make/],
  [() => stage.sand.put([1, 2]), /put takes a typed array.*\. Make one/],
  [() => stage.see(bytes(3 * 48)), /192 of them for 8 x 6 pixels, not 144 numbers in a Uint8Array\. Pass/],
  [() => stage.see(bytes(4 * 48, Uint16Array)), /not 192 numbers in a Uint16Array/],
  [() => stage.see({ width: 8, height: 6 }), /not no numbers/],
  [() => stage.see({ ...bytes(192), width: 4.5 }), /of them for 4\.5 x 6/],
  [() => stage.see(bytes(192), { centre: [3, 0] }), /shows the middle of the camera's view\. Pass/],
  [() => stage.see(bytes(192), { fov: 50 }), /see takes no "fov"\. It takes: orientation/],
  [() => stage.createSand({ particles: 1e7 }), /no 10000000 particles of 0\.006 m\. Pass at most 4000000/],
  [() => stage.createSand({ radius: 1e-5 }), /a radius from 0\.0001 to 10 m/],
  [() => stage.createSand({ static_friction: -1 }), /static_friction must be 0 to 10/],
  [() => stage.createSand({ particles: 4e6 }), /there is no memory for \d+ bytes\. Make/],
  [() => stage.createSand({ particles: 2.5 }), /no 2\.5 particles.*at most 4000000, a whole number/],
  [() => stage.addPlace({ ...many(1_000_001), ...k_here }), /a place has 1000000 triangles at most, .* 1000001\. Simp/],
  [() => stage.addPlace({ ...k_tetrahedron, indices: [], ...k_here }), /no triangles\. Add an object that has a mesh/],
  [() => stage.addPlace(turned([0, 0, 0, 0])), /addPlace: rotation must be 4 numbers.*not all 0/],
  [() => stage.setHands(joints(24)), /has the 25 joints of WebXR, in their order, not 24\. Pass null/],
  [() => stage.setHands(null, null, null), /setHands takes 2 hands, not 3/],
  [() => stage.setHands(joints(25, { radius: 0 })), /a joint: radius must be a number above 0/],
  [() => stage.setHands(joints(25, { position: [NaN, 0, 0] })), /a joint: position must be 3 numbers/],
  [() => stage.seeDepth(depth({ data: new Uint8Array(48) })), /8 x 6 numbers in a Uint16Array or a Float32Array/],
  [() => stage.seeDepth(depth({ height: 7 })), /8 x 7 numbers in a/],
  [() => stage.seeDepth(depth({ focal: [0, 9] })), /focal, centre or toMetres is out of range\. Pass/],
  [() => stage.seeDepth(depth({ centre: [4, 9] })), /centre or toMetres is out of range\. Pass/],
  [() => stage.seeDepth(depth({ position: [0, NaN, 0] })), /seeDepth: position must be 3 numbers/],
  [() => stage.seeDepth(depth({ fov: 50 })), /seeDepth takes no "fov"\. It takes: data/],
  [() => stage.addModel({ ...many(1_000_000), ...k_here }), /1,000,000 triangles at most.* have 1,000,004\. Simp/],
  [() => stage.addModel({ ...k_tetrahedron, indices: [0, 1, 4], ...k_here }), /indices name vertex 4 of 4\. Pass/],
  [() => stage.addModel({ ...k_tetrahedron, indices: [0, 1], ...k_here }), /three indices a triangle\. Pass/],
  [() => stage.addModel({ ...k_tetrahedron, positions: Array(12).fill(NaN), ...k_here }), /not finite\. Check/],
  [() => stage.addModel(turned([0, 0, 0, 0])), /rotation must be 4 numbers.*not all 0/],
  [() => stage.move(model, [NaN, 0, 0], [0, 0, 0, 1]), /move: position must be 3 numbers/],
  [() => stage.move(99, [0, 0, 0], [0, 0, 0, 1]), /no model 99\. Pass/],
  [() => stage.remove(99), /no model 99\. Pass/],
  [
    () => stage.setWall({ x: [1, 0, 0], y: [0, 0, 0], z: [0, 1, 0], at: [0, 0, 0], low: [0, 0], high: [1, 1] }),
    /normal/,
  ],
  [() => stage.pour({ position: [0, 1, 0], radius: 0.001 }), /does not pour\. Pass a radius from 0\.006 to 0\.594 m/],
  [() => stage.pour({ position: [0, 1, 0], rotation: [0, 0, 0, 0] }), /rotation must be 4 numbers.*not all 0/],
  [() => stage.pour(...rows(9, (i) => ({ position: [0, i, 0] }))), /pour takes 8 nozzles at most, not 9\. Pass/],
  [() => stage.push(...rows(32, () => ball)), /push takes 31 balls at most, not 32\. Pass/],
  [() => stage.push({ position: [0, 0.2, 0] }), /a ball: radius must be a number above 0/],
  [() => stage.push({ ...ball, radius: -1 }), /radius must be a number above 0/],
  [() => stage.push({ ...ball, position: [0, NaN, 0] }), /a ball: position must be 3 numbers/],
  [() => stage.push({ ...ball, position: undefined }), /a ball: position must be 3 numbers/],
  [() => stage.push({ ...ball, speed: 1 }), /a ball takes no "speed"\. It takes: position, radius, velocity/],
  [() => stage.frame(NaN), /seconds since the last frame/],
];
const size = stage.sand.memory.buffer.byteLength;
for (const [call, sentence] of refused) {
  assert.throws(call, sentence);
  for (const block of [1e5, 1e6, 1e7].map((room) => stage.sand.allocate(room))) stage.sand.free(block); // over what was freed
  const { particles, shadowOpacity } = frames(2);
  assert.deepEqual([particles, shadowOpacity], [300, 1], String(call));
}
assert.equal(stage.relief, 0); // nothing was made for what was refused
assert.ok(stage.sand.bytes(held, k_held).every((byte) => byte === 7));
assert.ok(stage.sand.memory.buffer.byteLength - size < 1 << 27, "what was refused is kept");

// The controls: what is right is taken. A plain array is an image; more than a quarter of the most triangles is a model, also
// beside others; places are vectors.
stage.see({ ...bytes(192), data: Array(192).fill(99) });
const large = stage.addModel({ ...many(300_000), ...k_here }, { collide: false });
frames(2);
stage.remove(large);
stage.setHands(joints(25), joints(25));
stage.seeDepth(depth());
assert.notEqual(stage.relief, 0);
const scan = { ...k_tetrahedron, indices: [0, 1, 2], ...k_here };
const places = rows(256, () => stage.addPlace(scan));
assert.throws(() => stage.addPlace(scan), /holds 256 open meshes of places\. Remove one, or join them/);
places.forEach((place) => stage.remove(place));
frames(2);
stage.push(...rows(31, () => ({ ...ball, position: { x: 0, y: 0.2, z: 0.1 } })));
stage.move(model, { x: 0, y: 0, z: 0, w: 1 }, { x: 0, y: 0, z: 0, w: 1 });
stage.createSand({ particles: 200 });
stage.pour(...rows(8, () => ({ position: { x: 0, y: 0.3, z: 0 }, rotation: { x: 0, y: 0, z: 0, w: 1 } })));
assert.ok(frames(60).particles > 100);

// A lamp in the middle of an image lies where the camera's axis does not.
const seen = new Uint8Array(4 * 64 * 48).fill(40);
for (let i = 0; i < seen.length; i += 4)
  if (Math.hypot(((i >> 2) & 63) - 31.5, (i >> 8) - 23.5) < 5) seen.fill(255, i, i + 4);
const to = async (view) => {
  const other = new Stage(stage.sand);
  other.see({ data: seen, width: 64, height: 48 }, { diagonal: 70, ...view });
  return other.frame(0.1).light.toLight;
};
const [middle, right, above] = [await to({}), await to({ centre: [0.8, 0] }), await to({ centre: [0, 0.8] })];
assert.ok(
  Math.abs(middle[0]) < 0.1 && right[0] - middle[0] > 0.25 && above[1] - middle[1] > 0.1,
  `${[middle, right, above]}`,
);
console.log(`${refused.length} refusals, and all is as it was`);
