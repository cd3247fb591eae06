// A slow device makes a skin's chunks in any order: what is there is drawn, whatever is not.
// node painter_test.mjs NPM_FOLDER
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
const { SandPainter } = await import(pathToFileURL(`${process.argv[2]}/sand_painter.mjs`));

const drawn = []; // the counts of gl.drawElements
const gl = new Proxy(
  {},
  {
    get:
      (_, name) =>
      (...given) => {
        if (name === "drawElements") drawn.push(given[1]);
        return 1;
      },
  },
);
const painter = new SandPainter(gl, "", new Uint8Array(8), 0.003);
const chunk = (number, count) => ({ number, vertices: new Uint8Array(24), indices: new Uint16Array(count) });
const shown = (...chunks) => {
  painter.upload({ chunks, flying: 0, lying: 0, loose: new Float32Array(0), low: [0, 0, 0], high: [0, 0, 0] });
  drawn.length = 0;
  painter.draw(() => {}, [0, 0, 1], 1);
  return [...drawn];
};
assert.deepEqual(shown(), []);
assert.deepEqual(shown(chunk(3, 6)), [6]);
assert.deepEqual(shown(chunk(1, 3), chunk(5, 9)), [3, 6, 9]);
painter.clear();
assert.deepEqual(shown(), []);
painter.end();
console.log("chunks in any order are drawn");
