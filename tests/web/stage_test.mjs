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
