// A slow device makes a skin's chunks in any order: what is there is drawn, whatever is not.
// node painter_test.mjs NPM_FOLDER
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
const { SandPainter } = await import(pathToFileURL(`${process.argv[2]}/sand_painter.mjs`));

const drawn = []; // the counts of gl.drawElements
const squares = []; // indices of each gl.drawElementsInstanced
const gl = new Proxy(
  {},
  {
    get:
      (_, name) =>
      (...given) => {
        if (name === "drawElements") drawn.push(given[1]);
        if (name === "drawElementsInstanced") squares.push(given[1]);
        return 1;
      },
  },
);
const painter = new SandPainter(gl, "", new Uint8Array(8), 0.003);
const chunk = (number, count) => ({ number, vertices: new Uint8Array(24), indices: new Uint16Array(count) });
const shown = (...chunks) => {
  painter.upload({ chunks, flying: 0, lying: 0, loose: new Float32Array(0) });
  drawn.length = 0;
  painter.draw(() => {}, [], [], 1);
  return [...drawn];
};
assert.deepEqual(shown(), []);
assert.deepEqual(shown(chunk(3, 6)), [6]);
assert.deepEqual(shown(chunk(1, 3), chunk(5, 9)), [3, 6, 9]);
painter.clear();
assert.deepEqual(shown(), []);

// Of the 256 squares of what lies, n are needed where a grain of 0.6 mm is seen sqrt(n / 256) * 1.5 pixels thick; here it is 3 pixels
// from 1 m. Of a particle that weighs less, as much less; of what is behind the eye, none.
const upright = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const projection = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, -0.1, 0];
const needed = (...particles) => {
  const loose = Float32Array.from(particles.flatMap(([z, weight]) => [0, 0, z, weight, 0, 1, 0, 7]));
  painter.upload({ chunks: [], flying: 0, lying: particles.length, loose });
  squares.length = 0;
  painter.draw(() => {}, upright, projection, 10000);
  return squares.map((indices) => indices / 6);
};
assert.deepEqual(needed([-4, 1]), [64]);
assert.deepEqual(needed([-8, 1], [-4, 0.5], [1, 1]), [32]);
assert.deepEqual(needed([-0.5, 1], [-4, 1]), [256]);
assert.deepEqual(needed([1, 1]), [1]);
painter.share = 0.125;
assert.deepEqual(needed([-0.5, 1]), [32]);
painter.end();
console.log("chunks in any order are drawn, and as many squares as the particles need");
