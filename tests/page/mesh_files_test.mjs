// The page's reader of mesh files: every kind that tests/mesh makes is read as the program reads it, or refused with the
// same sentence; whatever is cut or changed gives either triangles whose numbers hold, or one sentence. Links: a recording
// comes back as it was.
// node mesh_files_test.mjs PAGE_FOLDER KINDS_FOLDER
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { toLink, fromLink } from "../../models/page/link.mjs";
import { meshReader, standing } from "../../models/page/mesh_file.mjs";

const k_damages = 800;
const [page, kinds] = process.argv.slice(2);
const { MeshoptDecoder } = await import(join(page, "meshopt_decoder.mjs"));
const read = await meshReader(readFileSync(join(page, "mesh_reader.wasm")), MeshoptDecoder);

const cases = JSON.parse(readFileSync(join(kinds, "cases.json")));
for (const { name, size, triangles, refused } of cases) {
  const bytes = readFileSync(join(kinds, name));
  if (refused) {
    assert.throws(
      () => read(bytes, name),
      (error) =>
        /^Cannot read .*\.$/.test(error.message) && error.message.includes(refused) && error.message.includes(name),
      name,
    );
    continue;
  }
  const mesh = read(bytes, name);
  assert.equal(mesh.indices.length, 3 * triangles, name);
  for (let axis = 0; axis < 3; ++axis) {
    const along = mesh.vertices.filter((_, i) => i % 3 === axis);
    const found = Math.max(...along) - Math.min(...along);
    assert.ok(Math.abs(found - size[axis]) <= 1e-4 * size[axis], `${name} is ${found} along axis ${axis}`);
  }
}
assert.ok(cases.length > 40);

// A mesh stands as high as it is asked to, or lower where it would be too wide.
for (const [side, high] of [
  [1, 0.2],
  [5, 0.1],
]) {
  const { vertices } = standing(read(Buffer.from(`v 0 0 0\nv ${side} 0 0\nv 0 1 0\nf 1 2 3\n`), "a.obj"), 0.2, 0.5);
  assert.ok(Math.abs(vertices[7] - high) < 1e-6 && Math.abs(vertices[3] - vertices[0] - high * side) < 1e-6);
}

// Changed bytes at places of a fixed sequence, in every file that is read.
let seed = 1;
let accepted = 0;
let damaged = 0;
const random = (below) => (seed = (seed * 1664525 + 1013904223) >>> 0) % below;
for (const { name } of cases.filter(({ refused }) => !refused)) {
  const good = readFileSync(join(kinds, name));
  for (let i = 0; i < k_damages; ++i) {
    const bytes = Buffer.from(good);
    for (let k = random(3); k >= 0; --k)
      bytes[random(bytes.length)] = random(2) ? random(256) : '0123456789-.e[]{},:"'.charCodeAt(random(20));
    ++damaged;
    let mesh;
    try {
      mesh = read(bytes, name);
    } catch (error) {
      assert.ok(error.constructor === Error && error.message.startsWith("Cannot read"), error.stack);
      continue;
    }
    ++accepted;
    assert.ok(
      mesh.indices.length > 0 &&
        mesh.indices.every((i) => i < mesh.vertices.length / 3) &&
        mesh.vertices.every(Number.isFinite),
    );
  }
}
assert.ok(accepted > damaged / 100 && accepted < damaged, `${accepted} of ${damaged} damaged files were taken`);

// A recording as a link: numbers of 32 bits come back to the bit, and what is repeated costs next to nothing.
const third = Math.fround(1 / 3);
const frame = {
  emitters: [{ position: [third, 0.5, -third], rotation: [0, 0, 0, 1], radius: Math.fround(0.024), speed: 1 }],
  colliders: [],
  level: 2,
  runs: [
    [0, 3],
    [3, 1],
  ],
  gravity: [0, Math.fround(-9.81), third],
  tipped: true,
};
const plain = { emitters: [], colliders: [], level: 0, runs: [[0, 1]] };
const recording = {
  sandglass: "recording",
  scene: "table",
  step: 1 / 60,
  hash: "0x0123456789abcdef",
  frames: [plain, frame, frame, { ...frame, added: [{ particles: [third, 1e-7] }] }, plain],
};
const bits = (value) =>
  JSON.stringify(value, (_, x) => (typeof x === "number" ? Math.fround(x) : x === undefined ? null : x));
const link = await toLink(recording);
const back = await fromLink(link);
assert.equal(back.hash, recording.hash);
assert.equal(back.step, recording.step);
recording.frames.forEach((wanted, i) => {
  for (const [name, value] of Object.entries(wanted)) assert.equal(bits(back.frames[i][name]), bits(value));
});
assert.equal(back.frames[4].gravity, undefined);
assert.equal(back.frames[4].added, undefined);
assert.match(link, /^#r=[\w-]+$/);
const long = await toLink({ ...recording, frames: Array(3000).fill(frame) });
assert.ok(long.length < link.length + 100, `${long.length} characters for 3000 equal frames`);
await assert.rejects(
  toLink({ ...recording, frames: Array.from({ length: 20000 }, (_, i) => ({ ...frame, level: (i * 7919) % 104729 })) }),
  /Save it as a file/,
);
assert.equal(await fromLink("#elsewhere"), null);
for (let length = 3; length < link.length - 1; ++length)
  await assert.rejects(fromLink(link.slice(0, length)), /cut off or damaged/);
console.log(
  `${cases.length} kinds; ${accepted} of ${damaged} changed files still are a mesh; the link has ${link.length} characters`,
);
