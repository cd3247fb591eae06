// The demo scene in the module ends in the hash that every other instruction set has:
//     node golden.mjs NPM_FOLDER WEB_SCENE HASH_FILE ISA FRAMES [--friction NUMBER | --threads NUMBER]
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [npm, webScene, hashFile, isaName, frames, option, number] = process.argv.slice(2);
const from = (name) => import(pathToFileURL(join(npm, name)));
const { load } = await from("sandglass.mjs");
const { SandScene } = await from("scene.mjs");

const folder = mkdtempSync(join(tmpdir(), "sandglass-web-"));
execFileSync(webScene, ["demo", join(folder, "demo.json")]);
const file = JSON.parse(readFileSync(join(folder, "demo.json"), "utf8"));
rmSync(folder, { recursive: true });

let reading = 0;
const sand = await load(undefined, {
  now: () => (reading += file.virtual_step_ns) / 1e6,
  threads: option === "--threads" ? Number(number) : 1,
});
const isa = [...Array(16).keys()].find((number) => sand.sandglass_isa_name(number) === isaName);
if (!sand.sandglass_isa_available(isa)) throw new Error(`this build lacks ${isaName}`);
const changes = option === "--friction" ? { static_friction: Number(number) } : {};
const scene = new SandScene(sand, file, { isa, clock: true, changes });
const used = sand.sandglass_isa_name(sand.sandglass_scene_isa(scene.handle));
if (used !== isaName) throw new Error(`the scene runs ${used} and not ${isaName}`);
for (let frame = 0; frame < Number(frames); ++frame) scene.frame(file.frame_step, file.budget_ms);

if (sand.threads > 1 && sand.helped === 0) throw new Error("the other threads did nothing");

const golden = new Map(
  readFileSync(hashFile, "utf8")
    .split("\n")
    .filter((line) => /^\d/.test(line))
    .map((line) => line.split(" ")),
);
console.log(`${isaName}, ${sand.threads} threads: hash ${scene.hash()} after ${frames} frames`);
if (scene.hash() !== golden.get(frames)) {
  console.log(`it differs from the golden ${golden.get(frames)}`);
  process.exit(1);
}
