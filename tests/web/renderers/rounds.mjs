// What stages leave of themselves in an engine, and in the page.
import * as frame from "./scene.mjs";
import { babylonScene, done, shown, threeScene } from "./renderers.mjs";
import { createStage } from "sandglass/three";
import { createStage as createBabylonStage } from "sandglass/babylon";

// What is held after each of ten rounds of stages: what the engine counts; listeners and workers of the page.
const k_rounds = 10;
export async function left(engine, kind) {
  const three = engine === "three";
  const made = await (three ? threeScene(kind) : babylonScene(kind, false));
  const held = heldByPage();
  const count = () => [...(three ? heldByThree(made) : heldByBabylon(made)), ...held()].join(" ");
  const counts = [];
  let within;
  for (let i = 0; i < k_rounds; ++i) {
    await (three ? threeRound : babylonRound)(made, () => (within = count()));
    counts.push(count());
  }
  held.end();
  if (three) done(made.renderer);
  else made.engine.dispose();
  return { counts, within };
}
async function madeAndShown(stage, material) {
  const heights = {
    cells: [2, 2],
    heights: [0, 0, 0, 0],
    corner: [0, 0, 0],
    along: [1, 0, 0],
    across: [0, 0, 1],
    up: [0, 1, 0],
  };
  stage.receiveByDepth({ heights });
  stage.receive(material);
  stage.receive(material);
  await stage.createSand({ particles: 100 });
  await stage.createSand({ particles: 100 });
  stage.take(await frame.recorded());
}
async function threeRound({ THREE, renderer, camera }, isShown) {
  const scene = new THREE.Scene();
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.MeshStandardMaterial());
  scene.add(floor);
  const stage = await createStage(THREE, { renderer, scene, worker: true });
  await madeAndShown(stage, floor.material);
  renderer.render(scene, camera);
  isShown();
  stage.dispose();
  renderer.render(scene, camera);
  floor.geometry.dispose();
  floor.material.dispose();
  renderer.render(new THREE.Scene(), camera);
}
async function babylonRound({ BABYLON, scene, look }, isShown) {
  const floor = BABYLON.CreateGround("", { width: 2, height: 2 }, scene);
  floor.material = new BABYLON.PBRMaterial("", scene);
  const stage = await createBabylonStage(BABYLON, { scene, worker: true });
  await madeAndShown(stage, floor.material);
  await shown(scene, look);
  isShown();
  stage.dispose();
  floor.dispose(false, true);
  await look();
}
const heldByThree = ({ renderer: { info } }) => [JSON.stringify(info.memory), info.programs?.length];
function heldByBabylon({ engine, scene }) {
  const { textures, materials, meshes, lights } = scene;
  const all = [textures, materials, meshes, lights, scene.geometries, engine.getLoadedTexturesCache()];
  return [...all.map((one) => one.length), Object.keys(engine._compiledEffects).length];
}
function heldByPage() {
  const { addEventListener, removeEventListener } = EventTarget.prototype;
  const { Worker } = globalThis;
  let [listeners, workers] = [0, 0];
  EventTarget.prototype.addEventListener = function (...how) {
    ++listeners;
    return addEventListener.apply(this, how);
  };
  EventTarget.prototype.removeEventListener = function (...how) {
    --listeners;
    return removeEventListener.apply(this, how);
  };
  globalThis.Worker = class extends Worker {
    constructor(...how) {
      super(...how);
      ++workers;
    }
    terminate() {
      --workers;
      super.terminate();
    }
  };
  const end = () => {
    Object.assign(EventTarget.prototype, { addEventListener, removeEventListener });
    globalThis.Worker = Worker;
  };
  return Object.assign(() => [listeners, workers], { end });
}
