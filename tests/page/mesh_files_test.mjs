// The page's readers of files from anywhere: a good glTF gives its triangles; whatever is cut or changed gives either
// triangles whose numbers hold, or one sentence, and nothing else. Links: a recording comes back as it was.
// node mesh_files_test.mjs
import assert from "node:assert/strict";
import { readGltf } from "../../models/page/gltf.mjs";
import { readObj, standing } from "../../models/page/obj.mjs";
import { toLink, fromLink } from "../../models/page/link.mjs";

const k_damages = 20000;
const places = [[0, 0, 0], [1, 0, 0], [0.5, 0, 0.9], [0.5, 0.9, 0.3]], corners = [0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
const description = (buffer) => ({ asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }],
  nodes: [{ children: [1], translation: [10, 0, 0] }, { mesh: 0, scale: [2, 2, 2], rotation: [0, Math.SQRT1_2, 0, Math.SQRT1_2] }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
  accessors: [{ bufferView: 0, componentType: 5126, count: 4, type: "VEC3" }, { bufferView: 1, componentType: 5123, count: 12, type: "SCALAR" }],
  bufferViews: [{ buffer: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 24 }], buffers: [buffer] });
const data = Buffer.concat([Buffer.from(new Float32Array(places.flat()).buffer), Buffer.from(new Uint16Array(corners).buffer)]);

function glb(json = description({ byteLength: data.length })) {
  let text = JSON.stringify(json);
  while (text.length % 4) text += " ";
  const head = Buffer.alloc(20), chunk = Buffer.alloc(8);
  head.write("glTF"), head.writeUInt32LE(2, 4), head.writeUInt32LE(28 + text.length + data.length, 8), head.writeUInt32LE(text.length, 12), head.write("JSON", 16);
  chunk.writeUInt32LE(data.length), chunk.write("BIN", 4);
  return Buffer.concat([head, Buffer.from(text), chunk, data]);
}
const gltf = (json) => Buffer.from(JSON.stringify(json));
const embedded = { uri: `data:application/octet-stream;base64,${data.toString("base64")}` };

// A quarter turn about y takes x to -z, and z to x.
for (const bytes of [glb(), gltf(description(embedded))]) {
  const mesh = readGltf(bytes);
  assert.deepEqual([...mesh.indices], corners);
  places.forEach(([x, y, z], i) => [10 + 2 * z, 2 * y, -2 * x].forEach((wanted, k) => assert.ok(Math.abs(mesh.vertices[3 * i + k] - wanted) < 1e-5)));
}

// A mesh stands as high as it is asked to, or lower where it would be too wide.
for (const [side, high] of [[1, 0.2], [5, 0.1]]) {
  const { vertices } = standing(readObj(`v 0 0 0\nv ${side} 0 0\nv 0 1 0\nf 1 2 3\n`), 0.2, 0.5);
  assert.ok(Math.abs(vertices[7] - high) < 1e-6 && Math.abs(vertices[3] - vertices[0] - high * side) < 1e-6);
}

// One sentence or two: what, and what to do.
function refused(read, words) {
  assert.throws(read, (error) => error.constructor === Error && /^[A-Z"].*\.$/.test(error.message) && (!words || error.message.includes(words)), words);
}
const wrong = (change, words, buffer = embedded) => { const json = description(buffer); change(json); refused(() => readGltf(gltf(json)), words); };
wrong((file) => { file.asset.version = "1.0"; }, "version");
wrong((file) => { file.buffers[0] = { uri: "chair.bin" }; }, "another file");
wrong((file) => { file.extensionsRequired = ["KHR_draco_mesh_compression"]; }, "compressed");
wrong((file) => { file.accessors[0].sparse = {}; }, "sparse");
wrong((file) => { file.accessors[0].count = 5; }, "beyond its data");
wrong((file) => { file.accessors[0].count = 1e9; }, "too many");
wrong((file) => { file.accessors[0].componentType = 5123; }, "floats");
wrong((file) => { file.bufferViews[1].byteOffset = -4; }, "accessor is wrong");
wrong((file) => { file.bufferViews[1].byteLength = 1e12; }, "accessor is wrong");
wrong((file) => { file.accessors[0].count = 3; }, "vertices that are not there");
wrong((file) => { file.nodes[1].children = [0]; }, "below itself");
wrong((file) => { file.nodes[1].scale = [1, "2", 3]; }, "scale");
wrong((file) => { file.nodes[1].matrix = Array(16).fill(1e300); }, "not finite");
wrong((file) => { delete file.nodes[1].mesh; }, "no triangles");
wrong((file) => { file.meshes = null; }, "mesh is missing");

// Every cut, and changed bytes at places of a fixed sequence.
const good = glb();
let seed = 1, accepted = 0;
const random = (below) => (seed = (seed * 1664525 + 1013904223) >>> 0) % below;
function survives(bytes) {
  let mesh;
  try { mesh = readGltf(bytes); } catch (error) {
    assert.ok(error.constructor === Error && error.message.startsWith("The file is no glTF"), error.stack);
    return;
  }
  ++accepted;
  assert.ok(mesh.indices.length > 0 && mesh.indices.every((i) => i < mesh.vertices.length / 3) && mesh.vertices.every(Number.isFinite));
}
for (let length = 0; length < good.length; ++length) survives(good.subarray(0, length));
for (let i = 0; i < k_damages; ++i) {
  const bytes = Buffer.from(good);
  for (let k = random(3); k >= 0; --k) bytes[random(bytes.length)] = random(2) ? random(256) : "0123456789-.e[]{},:\"".charCodeAt(random(20));
  survives(bytes);
}
assert.ok(accepted > k_damages / 100 && accepted < k_damages, `${accepted} of ${k_damages} damaged files were taken`);
refused(() => readObj("v 0 0 0\nf 1 2 3\n"), "Line 2");

// A recording as a link: numbers of 32 bits come back to the bit, and what is repeated costs next to nothing.
const third = Math.fround(1 / 3);
const frame = { emitters: [{ position: [third, 0.5, -third], rotation: [0, 0, 0, 1], radius: Math.fround(0.024), speed: 1, grains_per_particle: 16 }], colliders: [],
  level: 2, runs: [[0, 3], [3, 1]], gravity: [0, Math.fround(-9.81), third], tipped: true };
const plain = { emitters: [], colliders: [], level: 0, runs: [[0, 1]] };
const recording = { sandglass: "recording", scene: "page", step: 1 / 60, hash: "0x0123456789abcdef", frames: [plain, frame, frame, { ...frame, added: [{ particles: [third], grains: [1e-7] }] }, plain] };
const bits = (value) => JSON.stringify(value, (_, x) => (typeof x === "number" ? Math.fround(x) : x === undefined ? null : x));
const link = await toLink(recording), back = await fromLink(link);
assert.equal(back.hash, recording.hash), assert.equal(back.step, recording.step);
recording.frames.forEach((wanted, i) => { for (const [name, value] of Object.entries(wanted)) assert.equal(bits(back.frames[i][name]), bits(value)); });
assert.equal(back.frames[4].gravity, undefined), assert.equal(back.frames[4].added, undefined);
assert.match(link, /^#r=[\w-]+$/);
const long = await toLink({ ...recording, frames: Array(3000).fill(frame) });
assert.ok(long.length < link.length + 100, `${long.length} characters for 3000 equal frames`);
await assert.rejects(toLink({ ...recording, frames: Array.from({ length: 20000 }, (_, i) => ({ ...frame, level: i * 7919 % 104729 })) }), /Save it as a file/);
assert.equal(await fromLink("#elsewhere"), null);
for (let length = 3; length < link.length - 1; ++length) await assert.rejects(fromLink(link.slice(0, length)), /cut off or damaged/);
console.log(`${accepted} of ${good.length + k_damages} cut or changed files still are a mesh; the link has ${link.length} characters`);
