// The same frame by three.js and Babylon.js, by every back end; and sand in three.js beside a common mesh.
import * as frame from "./scene.mjs";
import { createStage } from "sandglass/three";
import { createStage as createBabylonStage } from "sandglass/babylon";

const { side } = frame;
const k_background = 0x405060;
const truths = {};

// The kit's own picture of a scene.
async function truth(name, turned) {
  const THREE = await import("three");
  return (truths[name + turned] ??= await frame.ofKit(name, cameraOf(THREE, name), turned));
}
function cameraOf(THREE, name) {
  const { eye, target } = frame.scenes[name];
  const camera = new THREE.PerspectiveCamera(40, 1, 0.05, 20);
  camera.position.set(...eye);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  return camera;
}

// Browsers keep few contexts.
export function done(renderer) {
  renderer.dispose();
  renderer.forceContextLoss?.();
}

// What hides sand in a scene.
function threeOccluder(THREE, { positions, indices }) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  const material = new THREE.MeshBasicMaterial({ colorWrite: false, side: THREE.DoubleSide });
  return Object.assign(new THREE.Mesh(geometry, material), { renderOrder: -1 });
}
// `kind`: webgl; nodes, nodes on webgl (of WebGPURenderer). `change(drawn)`: before it is drawn.
export async function threeScene(
  kind,
  { name = frame.first, renderer: options = {}, change = (drawn) => drawn, hidden = false } = {},
) {
  const drawn = change(await frame.recorded(name));
  const THREE = await import(kind === "webgl" ? "three" : "three/webgpu");
  const canvas = frame.newCanvas();
  const how = { canvas, antialias: false, preserveDrawingBuffer: true, ...options };
  const renderer =
    kind === "webgl"
      ? new THREE.WebGLRenderer(how)
      : new THREE.WebGPURenderer({ ...how, forceWebGL: kind !== "nodes" });
  renderer.setSize(side, side, false);
  const scene = new THREE.Scene();
  const camera = cameraOf(THREE, name);
  const stage = await createStage(THREE, { renderer, scene });
  stage.stage = frame.replay(drawn);
  const group = await stage.createSand();
  if (hidden) scene.add(threeOccluder(THREE, drawn.mesh));
  stage.update(1 / 60);
  const look = async () => {
    renderer.render(scene, camera);
    const bytes = await frame.shown(canvas);
    return bytes;
  };
  return { THREE, renderer, scene, camera, stage, group, look, canvas };
}

export async function babylonScene(kind, left, name = frame.first) {
  const BABYLON = await import("babylon");
  const drawn = await frame.recorded(name);
  const { eye, target } = frame.scenes[name];
  const canvas = frame.newCanvas();
  const gpu = kind === "nodes";
  const engine = gpu
    ? new BABYLON.WebGPUEngine(canvas, { antialias: false })
    : new BABYLON.Engine(canvas, false, { preserveDrawingBuffer: true });
  if (gpu) await engine.initAsync();
  const scene = new BABYLON.Scene(engine);
  scene.useRightHandedSystem = !left;
  const mirrored = ([x, y, z]) => new BABYLON.Vector3(x, y, left ? -z : z);
  const camera = new BABYLON.FreeCamera("", mirrored(eye), scene);
  Object.assign(camera, { fov: (40 * Math.PI) / 180, minZ: 0.05, maxZ: 20 });
  camera.setTarget(mirrored(target));
  scene.clearColor = new BABYLON.Color4(0, 0, 0, 1);
  const occluder = new BABYLON.Mesh("", scene);
  occluder.setVerticesData("position", drawn.mesh.positions);
  occluder.setIndices(drawn.mesh.indices);
  occluder.scaling.z = left ? -1 : 1;
  occluder.material = new BABYLON.StandardMaterial("", scene);
  Object.assign(occluder.material, { disableColorWrite: true, backFaceCulling: false });
  const stage = await createBabylonStage(BABYLON, { scene });
  stage.stage = frame.replay(drawn);
  await stage.createSand();
  stage.update(1 / 60);
  await scene.whenReadyAsync();
  const look = () => {
    engine.beginFrame();
    scene.render();
    engine.endFrame();
    return frame.shown(canvas);
  };
  return { BABYLON, engine, scene, camera, stage, look, canvas, occluder };
}

// Of each way: how far it is from the kit's own picture; its milliseconds and draw calls, and those of the kit.
export async function same(engine, kind, name, left = false) {
  const wanted = await truth(name, kind === "nodes");
  const three = engine === "three";
  const made = await (three ? threeScene(kind, { name, hidden: true }) : babylonScene(kind, left, name));
  const { bytes, ms } = await frame.least(made.look);
  const { render } = made.renderer?.info ?? {};
  const counted = () => (three ? (render.drawCalls ?? render.calls) : made.engine._drawCalls.current);
  const before = kind === "webgl" && three ? 0 : counted(); // WebGLRenderer counts each picture alone
  const last = made.look();
  const calls = counted() - before;
  await last;
  if (three) done(made.renderer);
  else made.engine.dispose();
  const kit = { ms: wanted.ms, calls: wanted.calls };
  return { ...frame.difference(wanted.bytes, bytes), ms, calls, kit, picture: frame.pictured(wanted.bytes, bytes) };
}
// Of the kit's picture, all numbers.
export const light = async () => (await truth(frame.first, false)).bytes.reduce((sum, x) => sum + x, 0);

// Ways in which it would not be the same.
const k_faults = {
  "no sun share": { change: (drawn) => ({ ...drawn, pileOpacity: 0, shadowOpacity: 0 }) },
  "interpolated origin": {
    change: (drawn) => ({
      ...drawn,
      skin: {
        ...drawn.skin,
        chunks: drawn.skin.chunks.map(({ indices, ...chunk }) => ({ ...chunk, indices: turnedCorners(indices) })),
      },
    }),
  },
  "linear for sRGB": { after: ({ renderer, THREE }) => (renderer.outputColorSpace = THREE.LinearSRGBColorSpace) },
};
function turnedCorners(indices) {
  const corners = indices.slice();
  for (let i = 0; i < corners.length; i += 3)
    [corners[i], corners[i + 1], corners[i + 2]] = [corners[i + 2], corners[i], corners[i + 1]];
  return corners;
}
export async function fault(kind, name) {
  const made = await threeScene(kind, { ...k_faults[name], hidden: true });
  k_faults[name].after?.(made);
  const { bytes } = await truth(frame.first, kind === "nodes");
  const found = frame.difference(bytes, await made.look());
  done(made.renderer);
  return found;
}

// How sand's pixels and those of a ball of MeshStandardMaterial change: red, green, blue of each.
function means(bytes, plain) {
  const sums = { sand: [0, 0, 0, 0], ball: [0, 0, 0, 0] };
  for (let i = 0; i < plain.length; i += 4) {
    if (plain[i] + plain[i + 1] + plain[i + 2] === 0) continue;
    const [column, row] = [(i / 4) % side, i / 4 / side];
    const sum = sums[column > 0.68 * side && row > 0.66 * side ? "ball" : "sand"];
    for (let k = 0; k < 3; ++k) sum[k] += bytes[i + k];
    ++sum[3];
  }
  return Object.fromEntries(Object.entries(sums).map(([name, sum]) => [name, [0, 1, 2].map((k) => sum[k] / sum[3])]));
}
const k_looks = {
  plain: () => {},
  "ACES tones": ({ renderer, THREE }) =>
    Object.assign(renderer, { toneMapping: THREE.ACESFilmicToneMapping, toneMappingExposure: 0.5 }),
  "AgX tones": ({ renderer, THREE }) =>
    Object.assign(renderer, { toneMapping: THREE.AgXToneMapping, toneMappingExposure: 0.5 }),
  fog: ({ scene, THREE }) => (scene.fog = new THREE.Fog(0x0000ff, 0.3, 1)),
  layers: ({ camera, group, ball }) => {
    camera.layers.set(1);
    ball.layers.set(2);
    group.traverse((one) => one.layers.set(2));
  },
  invisible: ({ group, ball }) => (group.visible = ball.visible = false),
  // What lies or flies alone has no triangles but in its own material.
  "an override material": ({ scene, stage, THREE }) => {
    for (const one of stage.sand.loose) one.layers.set(2);
    scene.overrideMaterial = new THREE.MeshBasicMaterial({ color: 0x802020 });
  },
  "Display P3, ACES tones": async ({ renderer, THREE }) => {
    const { DisplayP3ColorSpace, DisplayP3ColorSpaceImpl } = await import("three/addons/math/ColorSpaces.js");
    THREE.ColorManagement.define({ [DisplayP3ColorSpace]: DisplayP3ColorSpaceImpl });
    Object.assign(renderer, { outputColorSpace: DisplayP3ColorSpace, toneMapping: THREE.ACESFilmicToneMapping });
  },
};
// By WebGLRenderer's own composer: GTAO asks for normals by a material of its own.
async function byComposer({ renderer, scene, camera, canvas, THREE }) {
  const from = (name) => import(`three/addons/postprocessing/${name}.js`);
  const [{ EffectComposer }, { RenderPass }, { GTAOPass }, { OutputPass }] = await Promise.all(
    ["EffectComposer", "RenderPass", "GTAOPass", "OutputPass"].map(from),
  );
  const composer = new EffectComposer(renderer);
  for (const pass of [new RenderPass(scene, camera), new GTAOPass(scene, camera, side, side), new OutputPass()])
    composer.addPass(pass);
  Object.assign(renderer, { toneMapping: THREE.ACESFilmicToneMapping, toneMappingExposure: 0.5 });
  return () => {
    composer.render();
    return frame.shown(canvas);
  };
}
export async function besideABall(kind) {
  const made = await threeScene(kind);
  const { THREE, scene, renderer, look } = made;
  const ball = new THREE.Mesh(new THREE.SphereGeometry(0.04), new THREE.MeshStandardMaterial({ color: 0xb09070 }));
  ball.position.set(0.12, 0.12, -0.525).applyMatrix4(made.camera.matrixWorld);
  scene.add(ball);
  let plain = await look();
  // Of the sand's colour, as tones and fog change what is light otherwise than what is dark.
  const { sand, ball: own } = means(plain, plain);
  ["r", "g", "b"].forEach((name, k) => (ball.material.color[name] *= (sand[k] / own[k]) ** 2.2));
  plain = await look();
  const found = {};
  const looks = { ...k_looks, ...(kind === "webgl" ? { "a composer, GTAO, ACES tones": byComposer } : {}) };
  for (const [name, change] of Object.entries(looks)) {
    const own = await change({ ...made, ball });
    if (name.includes("tones") && kind === "webgl")
      scene.traverse((one) => one.material && (one.material.needsUpdate = true));
    const seen = await (typeof own === "function" ? own : look)();
    found[name] = means(seen, name.includes("override") ? seen : plain);
    Object.assign(renderer, { toneMapping: THREE.NoToneMapping, outputColorSpace: THREE.SRGBColorSpace });
    Object.assign(scene, { fog: null, overrideMaterial: null });
    made.camera.layers.set(0);
    made.group.traverse((one) => one.layers.set(0));
    ball.layers.set(0);
    made.group.visible = ball.visible = true;
  }
  done(renderer);
  return found;
}

// How many pixels are sand, in scenes in which it once was not there.
const count = (bytes, [r, g, b] = [0x40, 0x50, 0x60]) => {
  let found = 0;
  for (let i = 0; i < bytes.length; i += 4)
    if (Math.abs(bytes[i] - r) + Math.abs(bytes[i + 1] - g) + Math.abs(bytes[i + 2] - b) > 12) ++found;
  return found;
};
const k_scenes = {
  alone: () => {},
  "an occluder beneath": ({ THREE, scene }) => {
    const plane = new THREE.Mesh(
      new THREE.PlaneGeometry(4, 4).rotateX(-Math.PI / 2),
      new THREE.MeshBasicMaterial({ colorWrite: false }),
    );
    plane.position.y = -0.01;
    plane.renderOrder = -1;
    scene.add(plane);
  },
  "a stencil test before": ({ THREE, scene }) => {
    const material = new THREE.MeshBasicMaterial({
      colorWrite: false,
      depthWrite: false,
      stencilWrite: true,
      stencilFunc: THREE.NeverStencilFunc,
    });
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.1, 0.1), material);
    mesh.renderOrder = -1;
    scene.add(mesh);
  },
  "two viewports": ({ renderer, scene, camera }) => {
    renderer.setViewport(0, 0, side / 2, side);
    renderer.setScissor(0, 0, side / 2, side);
    renderer.setScissorTest(true);
    renderer.autoClear = false;
    renderer.clear();
    renderer.render(scene, camera);
    renderer.setViewport(side / 2, 0, side / 2, side);
    renderer.setScissor(side / 2, 0, side / 2, side);
  },
  "its group moved out": ({ group }) => group.position.set(9, 0, 0),
  "a wall before it": ({ THREE, scene }) => {
    const wall = new THREE.Mesh(new THREE.PlaneGeometry(9, 9), new THREE.MeshBasicMaterial({ color: k_background }));
    wall.position.set(0.08, 0.25, 0.45);
    scene.add(wall);
  },
  "half clipped": ({ renderer, scene, group, THREE }) => {
    const clippingPlanes = [new THREE.Plane(new THREE.Vector3(0, -1, 0), 0.04)];
    if (renderer.isWebGLRenderer) Object.assign(renderer, { clippingPlanes });
    else scene.add(Object.assign(new THREE.ClippingGroup(), { clippingPlanes }).add(group));
  },
};
export async function counted(kind, names, options) {
  const made = await threeScene(kind, { renderer: options });
  const { renderer, scene, group, THREE } = made;
  scene.background = new THREE.Color(k_background);
  const before = new Set(scene.children);
  const found = [];
  for (const name of names) {
    k_scenes[name](made);
    found.push(count(await made.look()));
    scene.add(group);
    for (const one of [...scene.children]) if (!before.has(one)) one.removeFromParent();
    group.position.set(0, 0, 0);
    renderer.setViewport(0, 0, side, side);
    renderer.setScissorTest(false);
    Object.assign(renderer, { autoClear: true, clippingPlanes: [] });
  }
  done(renderer);
  return found;
}

// Sand of one stage, of another beside it, and of both, in pixels.
export async function twoStages(kind) {
  const { THREE, renderer, scene, group, look } = await threeScene(kind);
  scene.background = new THREE.Color(k_background);
  const other = await createStage(THREE, { renderer, scene });
  other.stage = frame.replay(await frame.recorded());
  const groups = [group, await other.createSand()];
  other.update(1 / 60);
  groups.forEach((one, k) => {
    one.scale.setScalar(0.4);
    one.position.x = k ? 0.1 : -0.1;
  });
  const found = [];
  for (const seen of [
    [true, false],
    [false, true],
    [true, true],
  ]) {
    groups.forEach((one, k) => (one.visible = seen[k]));
    found.push(count(await look()));
  }
  done(renderer);
  return found;
}

// Which share of a floor the sand's shadow changes that three's own light throws.
export async function casts(kind) {
  const { THREE, renderer, scene, stage, group, look } = await threeScene(kind);
  renderer.shadowMap.enabled = true;
  stage.sun.visible = stage.probe.visible = false;
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(3, 3).rotateX(-Math.PI / 2), new THREE.MeshStandardMaterial());
  const sun = Object.assign(new THREE.DirectionalLight(), { castShadow: true });
  sun.position.set(1, 1, 0.3);
  Object.assign(sun.shadow.camera, { left: -0.5, right: 0.5, top: 0.5, bottom: -0.5 });
  Object.assign(floor, { receiveShadow: true }).position.y = -0.05;
  scene.add(floor, sun, sun.target);
  const seen = [];
  for (const castShadow of [false, true]) {
    group.traverse((one) => (one.castShadow = castShadow));
    seen.push(await look());
  }
  done(renderer);
  return frame.difference(...seen).over;
}

// How far from a vertex of the sand a ray from the eye ends, and how many vertices lie outside of its box.
export async function hit(kind) {
  const { THREE, camera, group, renderer, scene, stage } = await threeScene(kind);
  scene.updateMatrixWorld();
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(0, 0), camera);
  const [{ point }] = ray.intersectObject(group, true);
  const box = new THREE.Box3().setFromObject(group);
  const { radius } = await frame.recorded();
  let [beside, outside] = [Infinity, 0];
  for (const { geometry, visible } of stage.sand.chunks) {
    if (!visible) continue;
    const places = geometry.getAttribute("position");
    for (const i of new Set(geometry.index.array.subarray(0, geometry.drawRange.count))) {
      const place = new THREE.Vector3().fromBufferAttribute(places, i);
      beside = Math.min(beside, place.distanceTo(point));
      if (!box.containsPoint(place)) ++outside;
    }
  }
  done(renderer);
  return { beside, outside, radius };
}

// Sand after its context was lost and came back; under Babylon.js on a floor that receives shadows.
export async function lost() {
  const { renderer, look, canvas } = await threeScene("webgl");
  const back = new Promise((done) => canvas.addEventListener("webglcontextrestored", done));
  return backAgain(look, canvas, renderer.getContext(), back);
}
export async function babylonLost() {
  const { BABYLON, engine, scene, stage, look, canvas } = await babylonScene("webgl", false);
  const floor = BABYLON.CreateGround("", { width: 2, height: 2 }, scene);
  floor.material = Object.assign(new BABYLON.PBRMaterial("", scene), { metallic: 0, roughness: 1 });
  const bare = await shown(scene, look);
  stage.receive(floor.material);
  const before = await shown(scene, look);
  const back = new Promise((done) => engine.onContextRestoredObservable.addOnce(done));
  const found = await backAgain(look, canvas, engine._gl, back);
  engine.dispose();
  return { ...found, shadow: frame.difference(bare, before).over };
}
export async function shown(scene, look) {
  await scene.whenReadyAsync();
  return look();
}
async function backAgain(look, canvas, gl, back) {
  const before = await look();
  const extension = gl.getExtension("WEBGL_lose_context");
  const pause = () => new Promise((done) => setTimeout(done, 50));
  const gone = new Promise((done) => canvas.addEventListener("webglcontextlost", done));
  extension.loseContext();
  await gone;
  await pause(); // it is allowed once the event is over
  extension.restoreContext();
  await back;
  let found;
  // It asks for what it needs, and has it some pictures later.
  for (let i = 0; i < 100 && !(found?.over === 0); ++i) {
    found = frame.difference(before, await look());
    await pause();
  }
  return { ...found, error: gl.getError() };
}

// A floor of tiles, instanced, is lit as one floor is, a floor that received twice as one that did once.
export async function floors(kind) {
  const seen = {};
  for (const way of ["one", "twice", "instanced", "batched"]) {
    const { THREE, scene, stage, look, renderer, group } = await threeScene(kind);
    const material = new THREE.MeshStandardMaterial({ roughness: 1 });
    stage.receive(material);
    if (way === "twice") stage.receive(material);
    scene.add(floorOf(THREE, way, material));
    stage.update(1 / 60);
    group.visible = false;
    seen[way] = await look();
    done(renderer);
  }
  const [{ over: twice }, { over: instanced }, { over: batched }] = ["twice", "instanced", "batched"].map((way) =>
    frame.difference(seen.one, seen[way]),
  );
  return { twice, instanced, batched, floor: frame.difference(seen.one, new Uint8Array(seen.one.length)).sand };
}
function floorOf(THREE, kind, material) {
  const flat = (size) => new THREE.PlaneGeometry(size, size).rotateX(-Math.PI / 2);
  if (kind === "one" || kind === "twice") return new THREE.Mesh(flat(1.6), material);
  const places = Array.from({ length: 16 }, (_, i) =>
    new THREE.Matrix4().setPosition(0.4 * (i % 4) - 0.6, 0, 0.4 * (i >> 2) - 0.6),
  );
  const tiles =
    kind === "instanced"
      ? new THREE.InstancedMesh(flat(0.4), material, 16)
      : new THREE.BatchedMesh(16, 64, 96, material);
  const tile = kind === "batched" ? tiles.addGeometry(flat(0.4)) : 0;
  places.forEach((place, i) => tiles.setMatrixAt(kind === "batched" ? tiles.addInstance(tile) : i, place));
  return tiles;
}

// A surface above the floor is lit as by one layer which holds what the rule of the slide makes of three there; control: as by the
// floor's. In steps of a byte; and so for a place, of which only its shadows are seen.
export async function raised(kind) {
  const [number, height, above, texels] = [3, 0.4, 0.25, 16];
  const slide = [0.7, -0.3];
  const box = [-0.7, -0.7, 1 / 1.4, 1 / 1.4];
  const layer = (above / height) * (number - 1);
  const lower = Math.floor(layer);
  const layersOf = (turn) =>
    Array.from({ length: number }, (_, k) =>
      Uint8Array.from({ length: texels ** 2 }, (_, i) => 127 + 110 * Math.sin(turn + 2 * k + 0.5 * i + 0.9 * (i >> 4))),
    );
  const joined = (layers) => Uint8Array.from(layers.flatMap((one) => [...one]));
  const blended = (layers) =>
    layers[0].map((_, i) => Math.round(layers[lower][i] + (layer - lower) * (layers[lower + 1][i] - layers[lower][i])));
  const [shadow, occlusion] = [layersOf(0), layersOf(1)];
  const seen = async (of, change, how = "lit") => {
    const textures = {};
    Object.entries({ shadow, occlusion }).forEach(
      ([name, layers]) => (textures[name] = { side: texels, bytes: of(layers) }),
    );
    const drawn = {
      floor: 0,
      shadowBox: box,
      occlusionBox: box,
      shadowOpacity: 1,
      pileOpacity: 0,
      skyKnown: 0,
      textures,
      ...change,
    };
    const made = await threeScene(kind, { change: (recorded) => ({ ...recorded, ...drawn }) });
    const { THREE, scene, stage, look, renderer, group } = made;
    const material = new THREE.MeshStandardMaterial({ roughness: 1 });
    const plane = new THREE.PlaneGeometry(1.2, 1.2).rotateX(-Math.PI / 2);
    const mesh = new THREE.Mesh(plane, material);
    mesh.position.y = above;
    scene.add(mesh);
    if (how !== "lit") scene.background = new THREE.Color(1, 1, 1);
    if (how === "place") await stage.addPlace(mesh);
    else stage.receive(material, { shadowOnly: how === "shadow" });
    stage.update(1 / 60);
    group.visible = false;
    const bytes = await look();
    done(renderer);
    return bytes;
  };
  const half = 0.5 / texels;
  const layered = await seen(joined, { slide: [...slide, half, half], layers: [number, (number - 1) / height] });
  const slid = [box[0] + slide[0] * above, box[1] + slide[1] * above, box[2], box[3]];
  const flat = { slide: [0, 0, half, half], layers: [1, 0] };
  const farthest = (one, other) => one.reduce((most, byte, i) => Math.max(most, Math.abs(byte - other[i])), 0);
  const single = (of, how) => seen(of, { ...flat, shadowBox: slid }, how);
  const place = await seen(joined, { slide: [...slide, half, half], layers: [number, (number - 1) / height] }, "place");
  const ofFloor = (layers) => layers[0];
  return {
    off: farthest(layered, await single(blended)),
    control: farthest(layered, await single(ofFloor)),
    place: farthest(place, await single(blended, "shadow")),
    placeControl: farthest(place, await single(ofFloor, "shadow")),
  };
}

// The README's example: pixels that shadows darken, and that sand makes warmer.
export async function readme() {
  const canvas = document.body.appendChild(document.createElement("canvas"));
  await import("/renderers/readme.mjs");
  const { renderer, scene, camera, stage, floor } = globalThis.example;
  renderer.setAnimationLoop(null);
  await stage.stage.fields;
  for (let i = 0; i < 150; ++i) stage.update(1 / 60);
  const look = async (one, visible) => {
    one.visible = visible;
    renderer.render(scene, camera);
    return frame.shown(canvas);
  };
  const all = await look(floor, true);
  const bare = await look(stage.group, false);
  const unshaded = await look(floor, false);
  done(renderer);
  const pixels = (is) => all.reduce((sum, _, i) => sum + (i % 4 === 0 && is(i) ? 1 : 0), 0);
  const warmth = (bytes, i) => bytes[i] - bytes[i + 2];
  return {
    shadow: pixels((i) => unshaded[i] - bare[i] > 8),
    sand: pixels((i) => warmth(all, i) - warmth(bare, i) > 8),
    particles: stage.drawn.particles,
  };
}
