// Sand in several attachments of a target, in the two eyes of a headset, and behind glass.
import * as frame from "./scene.mjs";
import { babylonScene, done, threeScene } from "./renderers.mjs";

const { side, difference } = frame;
globalThis.XRWebGLBinding = class {}; // the browser's own takes no headset but its own

// How far the first attachment is from the picture without a second, and how many pixels of sand have something in the second.
export async function attachments(kind) {
  const { THREE, renderer, scene, camera, canvas } = await threeScene(kind);
  const looks = { webgl: ofTarget, nodes: ofPass, "nodes on webgl": ofPass };
  const look = looks[kind](THREE, renderer, scene, camera, canvas);
  const [alone] = await look(false);
  const [first, second] = await look(true);
  done(renderer);
  return { ...difference(alone, first), second: difference(second, second).sand };
}
const ofTarget = (THREE, renderer, scene, camera) => (many) => {
  const target = new THREE.WebGLRenderTarget(side, side, { count: many ? 2 : 1 });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  return target.textures.map((_, k) => {
    const bytes = new Uint8Array(4 * side * side);
    renderer.readRenderTargetPixels(target, 0, 0, side, side, bytes, undefined, k);
    return bytes;
  });
};
const ofPass = (THREE, renderer, scene, camera, canvas) => async (many) => {
  const { pass, mrt, output, normalView } = THREE.TSL;
  const seen = [];
  for (const name of many ? ["output", "normal"] : ["output"]) {
    const made = pass(scene, camera);
    if (many) made.setMRT(mrt({ output, normal: normalView.mul(0.5).add(0.5) }));
    const pipeline = new THREE.RenderPipeline(renderer, made.getTextureNode(name));
    pipeline.render();
    seen.push(await frame.shown(canvas));
  }
  return seen;
};
// Babylon.js draws into several attachments by its prepass; this one asks for depth and normals, and darkens nothing. It is compared with
// another pass, as rows of a texture are turned.
export async function prepass(kind) {
  const seen = [];
  for (const many of [false, true]) {
    const { BABYLON, engine, scene, camera, look, occluder } = await babylonScene(kind, false);
    occluder.setEnabled(false);
    if (many) new BABYLON.SSAO2RenderingPipeline("", scene, 1, [camera], false).totalStrength = 0;
    else new BABYLON.PassPostProcess("", 1, camera);
    await scene.whenReadyAsync();
    for (let i = 0; i < 3; ++i) seen[Number(many)] = await look();
    if (many && !(scene.prePassRenderer.mrtCount > 1)) throw new Error("there is no second attachment");
    engine.dispose();
  }
  return difference(...seen);
}

// Eyes of a headset: their frusta reach farther outwards than inwards, and not equally far up.
function eyesOf(THREE, middle) {
  const near = 0.05;
  const reach = 0.018;
  return [-1, 1].map((sign) => {
    const eye = new THREE.PerspectiveCamera();
    eye.coordinateSystem = middle.coordinateSystem;
    eye.position.copy(middle.position).add(new THREE.Vector3(0.032 * sign, 0, 0.01 * sign));
    eye.quaternion.copy(middle.quaternion);
    eye.updateMatrixWorld();
    const [left, right] = sign < 0 ? [-0.6, 0.4] : [-0.4, 0.6];
    const sides = [left, right, 1 + 0.1 * sign, -0.9].map((share) => share * reach);
    eye.projectionMatrix.makePerspective(...sides, near, 20, middle.coordinateSystem);
    eye.projectionMatrixInverse.copy(eye.projectionMatrix).invert();
    eye.viewport = new THREE.Vector4(sign < 0 ? 0 : side / 2, 0, side / 2, sign < 0 ? side : side / 2);
    return eye;
  });
}
// Draws by a headset that is made of cameras, as three asks WebXR for one.
async function byHeadset(renderer, eyes, draw) {
  const transform = ({ matrixWorld, position, quaternion: orientation }) => ({
    ...{ position, orientation, matrix: matrixWorld.elements },
    inverse: { matrix: matrixWorld.clone().invert().elements },
  });
  const views = eyes.map((eye, k) => ({
    eye: k ? "right" : "left",
    projectionMatrix: Float32Array.from(eye.projectionMatrix.elements),
    transform: transform(eye),
    viewport: { x: eye.viewport.x, y: eye.viewport.y, width: eye.viewport.z, height: eye.viewport.w },
  }));
  let next;
  const session = Object.assign(new EventTarget(), {
    ...{ inputSources: [], renderState: {}, enabledFeatures: [] },
    updateRenderState: (state) => Object.assign(session.renderState, state),
    requestReferenceSpace: async () => new EventTarget(),
    requestAnimationFrame: (run) => (next = run),
    cancelAnimationFrame() {},
  });
  const gl = renderer.getContext();
  const framebuffer = framebufferOf(gl);
  globalThis.XRWebGLLayer = class {
    framebuffer = framebuffer;
    framebufferWidth = side;
    framebufferHeight = side;
    getViewport = ({ viewport }) => viewport;
  };
  gl.makeXRCompatible = async () => {};
  renderer.xr.enabled = true;
  await renderer.setAnimationLoop(draw);
  await renderer.xr.setSession(session);
  next(0, { session, getViewerPose: () => ({ views, transform: views[0].transform }) });
  const bytes = new Uint8Array(4 * side * side);
  const bound = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, framebuffer);
  gl.readPixels(0, 0, side, side, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, bound);
  session.dispatchEvent(new Event("end"));
  renderer.xr.enabled = false;
  return bytes;
}
function framebufferOf(gl) {
  const before = gl.getParameter(gl.FRAMEBUFFER_BINDING);
  const framebuffer = gl.createFramebuffer();
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  for (const [attachment, format] of [
    [gl.COLOR_ATTACHMENT0, gl.RGBA8],
    [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24],
  ]) {
    const buffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorage(gl.RENDERBUFFER, format, side, side);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, before);
  return framebuffer;
}
// How far both eyes, as three's XR manager has them, are from what each sees alone; and from what they see exchanged. The camera that
// holds them stands behind them, as there.
export async function eyes(kind, worn = false) {
  const { THREE, renderer, scene, camera, canvas, look } = await threeScene(kind);
  await look();
  const two = eyesOf(THREE, camera);
  const both = new THREE.ArrayCamera(two).copy(camera, false);
  both.cameras = two;
  both.translateZ(0.5);
  if (!worn) renderer.render(scene, both);
  const seen = await (worn ? byHeadset(renderer, two, () => renderer.render(scene, camera)) : frame.shown(canvas));
  renderer.autoClear = false;
  const alone = async (order) => {
    renderer.clear();
    for (const [i, eye] of order.entries()) {
      const { x, y, z, w } = two[i].viewport;
      renderer.setViewport(x, y, z, w);
      renderer.render(scene, eye);
    }
    return frame.shown(canvas);
  };
  for (const eye of two) eye.isArrayCamera = false;
  const found = {
    ...difference(await alone(two), seen),
    other: difference(await alone([...two].reverse()), seen).over,
  };
  done(renderer);
  return found;
}
// The same of a camera of Babylon.js that has a camera for each eye.
export async function babylonEyes(kind) {
  const { BABYLON, engine, scene, camera, look, occluder } = await babylonScene(kind, false);
  occluder.setEnabled(false);
  camera.setCameraRigMode(BABYLON.Camera.RIG_MODE_STEREOSCOPIC_SIDEBYSIDE_PARALLEL, { interaxialDistance: 0.064 });
  await look();
  const eyes = camera.rigCameras;
  eyes.forEach((eye, k) => {
    const skewed = eye.getProjectionMatrix(true).clone();
    skewed.setRowFromFloats(2, k ? -0.2 : 0.2, 0.05, skewed.m[10], skewed.m[11]);
    eye.freezeProjectionMatrix(skewed);
  });
  const seen = await look();
  const singles = eyes.map((eye) => {
    const at = eye.getViewMatrix().clone().invert();
    const one = new BABYLON.FreeCamera("", at.getTranslation(), scene);
    one.rotationQuaternion = BABYLON.Quaternion.FromRotationMatrix(at.getRotationMatrix());
    one.freezeProjectionMatrix(eye.getProjectionMatrix());
    return one;
  });
  const alone = async (order) => {
    order.forEach((one, k) => (one.viewport = eyes[k].viewport));
    scene.activeCameras = order;
    return look();
  };
  const found = {
    ...difference(await alone(singles), seen),
    other: difference(await alone(singles.reverse()), seen).over,
  };
  engine.dispose();
  return found;
}
// A tinted plate of glass stands half in the heap, aslant. Of sand, of the same heap as a standard mesh of its mean colour, and of sand
// that says it is transparent, which glass shows not: what the glass makes of each channel behind it, and where (a picture of 0 and 1).
export async function behindGlass(kind) {
  const { THREE, renderer, scene, stage, group, look } = await threeScene(kind);
  for (const one of stage.sand.loose) one.visible = false;
  const tint = { color: 0x60a0ff, transmission: 1, roughness: 0, thickness: 0.006, ior: 1.5 };
  const plate = new THREE.Mesh(new THREE.BoxGeometry(0.12, 0.2, 0.006), new THREE.MeshPhysicalMaterial(tint));
  plate.position.set(0.03, 0.13, 0.07);
  plate.rotation.y = 0.4;
  scene.add(plate);
  const changes = async (heap) => {
    plate.visible = heap.visible = false;
    const bare = await look();
    heap.visible = true;
    const plain = await look();
    plate.visible = true;
    const seen = await look();
    const far = (a, b, i) => [0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > 4);
    const [behind, before, after] = [new Uint8Array(side * side), [0, 0, 0], [0, 0, 0]];
    for (let i = 0; i < 4 * side * side; i += 4) {
      if (!far(bare, plain, i) || !far(plain, seen, i)) continue;
      behind[i / 4] = 1;
      for (let k = 0; k < 3; ++k) [before[k], after[k]] = [before[k] + plain[i + k], after[k] + seen[i + k]];
    }
    heap.visible = false;
    const count = behind.reduce((sum, x) => sum + x);
    return { behind, count, mean: before.map((x) => x / count), shares: after.map((x, k) => x / before[k]) };
  };
  const sand = await changes(group);
  const heap = new THREE.Group();
  const material = new THREE.MeshStandardMaterial({ flatShading: true });
  for (const { geometry, visible } of stage.sand.chunks) if (visible) heap.add(new THREE.Mesh(geometry, material));
  scene.add(heap);
  const white = await changes(heap);
  ["r", "g", "b"].forEach((name, k) => (material.color[name] *= (sand.mean[k] / white.mean[k]) ** 2.2));
  const common = await changes(heap);
  for (const one of stage.sand.chunks) Object.assign(one.material, { transparent: true, needsUpdate: true });
  const blended = await changes(group);
  done(renderer);
  const other = sand.behind.reduce((sum, x, i) => sum + (x !== common.behind[i]), 0) / common.count;
  return { count: sand.count, other, sand: sand.shares, heap: common.shares, blended: blended.shares };
}
// Sand of Babylon.js as a mesh: how far from its skin a ray ends, and which share of a
// picture its shadow on a floor changes, and of the sand alone a clipping plane and fog.
export async function babylonMesh(kind, left) {
  const { BABYLON, engine, scene, stage, look, occluder } = await babylonScene(kind, left);
  occluder.setEnabled(false);
  const floor = BABYLON.CreateGround("", { width: 3, height: 3 }, scene);
  floor.material = Object.assign(new BABYLON.PBRMaterial("", scene), { metallic: 0, roughness: 1 });
  const z = left ? -1 : 1;
  const light = new BABYLON.DirectionalLight("", new BABYLON.Vector3(-1, -1.5, -0.5 * z), scene);
  light.position.set(1, 1.5, 0.5 * z);
  const ready = async () => {
    await scene.whenReadyAsync();
    await look();
    return look();
  };
  const plain = await ready();
  const { pickedPoint } = scene.pick(side / 2, 0.4 * side, (mesh) => mesh.name === "sand");
  const beside = Math.min(
    ...stage.sand.chunks
      .filter((one) => one.isVisible)
      .flatMap((one) => {
        const all = one.getVerticesData("position");
        return Array.from({ length: all.length / 3 }, (_, i) =>
          Math.hypot(...[1, 1, z].map((sign, k) => all[3 * i + k] - sign * pickedPoint.asArray()[k])),
        );
      }),
  );
  new BABYLON.ShadowGenerator(512, light).addShadowCaster(stage.sand.root);
  floor.receiveShadows = true;
  const changed = { shadows: difference(plain, await ready()).over };
  floor.setEnabled(false);
  const alone = await ready();
  scene.clipPlane = new BABYLON.Plane(0, 1, 0, -0.1);
  changed["a clipping plane"] = difference(alone, await ready()).over;
  scene.clipPlane = null;
  Object.assign(scene, { fogMode: BABYLON.Scene.FOGMODE_LINEAR, fogStart: 0.3, fogEnd: 1 });
  changed.fog = difference(alone, await ready()).over;
  engine.dispose();
  return { beside, changed, radius: stage.drawn.radius };
}
// How many pixels are sand of Babylon.js where materials have this depth: behind a wall, before it, and alone. The wall is small, as in
// logarithmic depth the engine draws no triangle that reaches behind the eye.
export async function babylonDepth(kind, way) {
  const { BABYLON, engine, scene, stage, look, occluder } = await babylonScene(kind, false);
  engine.useReverseDepthBuffer = way === "reversed";
  occluder.setEnabled(false);
  const wall = BABYLON.CreatePlane("", { size: 0.3, sideOrientation: 2 }, scene);
  wall.material = Object.assign(new BABYLON.PBRMaterial("", scene), {
    unlit: true,
    albedoColor: BABYLON.Color3.Black(),
    useLogarithmicDepth: way === "logarithmic",
  });
  stage.update(1 / 60);
  const seen = [];
  for (const z of [0.3, -0.4, 20]) {
    wall.position.set(0.12, 0.22, z);
    wall.scaling.setAll(z < 0 ? 6 : 1);
    await scene.whenReadyAsync();
    await look();
    const bytes = await look();
    seen.push(difference(bytes, new Uint8Array(bytes.length)).sand);
  }
  engine.dispose();
  return seen;
}
