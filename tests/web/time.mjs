// Processor time of a frame of the demo scene in the module, frames 31 to 90, all work in every frame:
//     node time.mjs NPM_FOLDER DEMO_JSON ISA [THREADS]
// The first frames are left out: the browser's compiler is still at work. DEMO_JSON is what `web_scene demo` writes.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [npm, path, isaName, threads = 1] = process.argv.slice(2);
const { load } = await import(pathToFileURL(join(npm, "sandglass.mjs")));
const { SandScene } = await import(pathToFileURL(join(npm, "scene.mjs")));
const sand = await load(undefined, { threads: Number(threads) });
const isa = [...Array(16).keys()].find((number) => sand.sandglass_isa_name(number) === isaName);
const scene = new SandScene(sand, JSON.parse(readFileSync(path, "utf8")), { isa });
const first = 30;
const last = 90;
let used, since;
for (let frame = 0; frame < last; ++frame) {
  if (frame === first) {
    used = process.cpuUsage();
    since = performance.now();
  }
  scene.frame();
}
console.log(
  `${isaName}: ${(process.cpuUsage(used).user / 1e3 / (last - first)).toFixed(2)} ms a frame, ${((performance.now() - since) / (last - first)).toFixed(2)} by the wall, hash ${scene.hash()}`,
);
