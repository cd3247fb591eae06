// The README's second example with Babylon.js, in a scene of either hand; in the left-handed one the floor is seen itself.
import * as BABYLON from "@babylonjs/core";
import { createStage } from "sandglass/babylon";
import { wasm } from "sandglass/inline";
import { worst } from "./cube.mjs";

const painted = (scene, ...colour) =>
  Object.assign(new BABYLON.PBRMaterial("", scene), {
    albedoColor: new BABYLON.Color3(...colour),
    metallic: 0,
    roughness: 1,
    metallicF0Factor: 0,
  });

// The light cube: a white one of Babylon.js in the stage's light, each face against the light itself.
async function lightCube(engine, stage, z, fault) {
  engine.stopRenderLoop();
  const small = new BABYLON.Scene(engine);
  const of = (...at) => new BABYLON.Vector3(...at);
  small.useRightHandedSystem = z > 0;
  small.imageProcessingConfiguration.applyByPostProcess = true; // linear
  const own = new stage.constructor(BABYLON, small, stage.stage);
  const box = BABYLON.CreateBox("box", { size: 1 }, small);
  const camera = new BABYLON.FreeCamera("", of(0, 0, 2), small);
  const target = new BABYLON.RenderTargetTexture("", 8, small, {
    type: BABYLON.Constants.TEXTURETYPE_FLOAT,
    generateMipMaps: false,
  });
  Object.assign(camera, {
    mode: BABYLON.Camera.ORTHOGRAPHIC_CAMERA,
    orthoLeft: -0.4,
    orthoRight: 0.4,
    orthoTop: 0.4,
    orthoBottom: -0.4,
    minZ: 0.1,
  });
  box.material = Object.assign(painted(small, 1, 1, 1), { specularIntensity: 0 });
  target.renderList = [box];
  target.activeCamera = camera;
  return worst(own, async (n) => {
    if (fault === "signs") {
      const h = own.around.sphericalPolynomial.preScaledHarmonics;
      for (const one of [h.l1_1, h.l10, h.l11]) one.scaleInPlace(-1);
    }
    if (fault === "pi") own.sun.diffuse = own.sun.diffuse.scale(1 / Math.PI);
    own.sun.specular = BABYLON.Color3.Black();
    camera.position.set(2 * n[0], 2 * n[1], 2 * n[2] * z);
    camera.upVector = n[1] ? of(1, 0, 0) : of(0, 1, 0);
    camera.setTarget(of(0, 0, 0));
    await small.whenReadyAsync();
    small.render();
    target.render();
    return (await target.readPixels())[0];
  });
}

async function begin(right) {
  const canvas = Object.assign(document.querySelector("canvas"), { width: innerWidth, height: (innerWidth * 3) / 4 });
  const engine = new BABYLON.Engine(canvas, true);
  const scene = new BABYLON.Scene(engine);
  scene.useRightHandedSystem = right;
  const z = right ? 1 : -1;
  const camera = new BABYLON.FreeCamera("camera", new BABYLON.Vector3(0, 1.1, 1.9 * z), scene);
  camera.fov = (56 * Math.PI) / 180;
  camera.minZ = 0.05;
  camera.setTarget(new BABYLON.Vector3(0, 1.1 - 1.9 * Math.tan(0.17), 0));
  const floor = BABYLON.CreateGround("floor", { width: 8, height: 8 }, scene);
  const model = BABYLON.CreateBox("model", { width: 0.4, height: 0.45, depth: 0.4 }, scene);
  model.position.y = 0.225;
  model.rotation.y = 0.4 * z;
  model.material = painted(scene, 0.2, 0.35, 0.5);
  floor.material = painted(scene, 0.32, 0.25, 0.18);
  const stage = await createStage(BABYLON, { scene, source: wasm() });
  const photo = await createImageBitmap(await (await fetch("room.jpg")).blob());
  await stage.see(photo, camera);
  await stage.addModel(model);
  if (right) new BABYLON.Layer("", "room.jpg", scene, true);
  stage.receive(floor.material, { shadowOnly: right });
  await stage.createSand({ particles: 3000 });
  stage.pour({ position: [0, 0.7, 0] });
  await scene.whenReadyAsync();
  const step = () => {
    stage.update(1 / 60);
    scene.render();
  };
  engine.runRenderLoop(step);

  const cube = (fault) => lightCube(engine, stage, z, fault);
  Object.assign(globalThis, { stage, cube, step, photo, gl: engine._gl });
}
begin(new URLSearchParams(location.search).get("app") === "right").then(
  () => {
    globalThis.ready = "yes";
  },
  (error) => {
    globalThis.ready = error.message;
  },
);
