// Shadows by depth in three.js, beside the formula in numbers of 64 bits: on a plane, a book and a slope.
import * as frame from "./scene.mjs";
import { babylonScene, done, shown, threeScene } from "./renderers.mjs";
import { createStage } from "sandglass/three";

const { side } = frame;
const k_texels = 16;
const [k_layers, k_height] = [3, 0.15];
const k_slide = [0.7, -0.3];
const k_box = [-0.7, -0.7, 1 / 1.4, 1 / 1.4];
const k_cell = 0.01; // metres, of the heights
const k_cells = 96;
const k_upright = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const [k_table, k_gone] = [0.3, -8]; // metres: where heights end along x, and their height beyond
const k_bias = 1.05; // what the image's depths are divided by
// The main light is 1.2 of a floor's, the rest 0.3 + 0.1 - 0.05 - 0.02.
const k_light = {
  toLight: [0.6, 0.8, 0],
  facing: [1.5 * Math.PI, 1.5 * Math.PI, 1.5 * Math.PI],
  ambient: Array.from({ length: 27 }, (_, i) => ({ 0: 0.3, 1: 0.1, 6: 0.05, 8: 0.02 })[Math.floor(i / 3)] ?? 0),
  radiance: new Array(27).fill(0),
  floor: [0, 0, 0],
};
const k_share = 1.2 / (1.2 + 0.33);

const layersOf = (turn) =>
  Uint8Array.from({ length: k_layers * k_texels ** 2 }, (_, i) => {
    const [k, x, z] = [Math.floor(i / k_texels ** 2), i % k_texels, Math.floor(i / k_texels) % k_texels];
    return 127 + 110 * Math.sin(turn + 1.3 * k + 0.4 * x + 0.5 * z);
  });
const k_images = { shadow: layersOf(0), occlusion: layersOf(1) };
const k_half = 0.5 / k_texels;
const k_drawn = {
  light: k_light,
  floor: 0,
  shadowBox: k_box,
  occlusionBox: k_box,
  shadowOpacity: 1,
  pileOpacity: 0,
  skyKnown: 0,
  slide: [...k_slide, k_half, k_half],
  layers: [k_layers, (k_layers - 1) / k_height],
  textures: Object.fromEntries(Object.entries(k_images).map(([name, bytes]) => [name, { side: k_texels, bytes }])),
};

// ---- The formula

const clamped = (x, low, high) => Math.min(Math.max(x, low), high);
const blended = (a, b, part) => a + (b - a) * part;
function bilinear(at, columns, rows, x, y) {
  const [u, v] = [clamped(x * columns - 0.5, 0, columns - 1), clamped(y * rows - 0.5, 0, rows - 1)];
  const [i, j] = [Math.min(Math.floor(u), columns - 2), Math.min(Math.floor(v), rows - 2)];
  const row = (k) => blended(at(k * columns + i), at(k * columns + i + 1), u - i);
  return blended(row(j), row(j + 1), v - j);
}
const isIn = (...at) => at.every((x) => x > 0 && x < 1);
function layered(image, x, z, above, outside) {
  const at = [(x - k_box[0]) * k_box[2], (z - k_box[1]) * k_box[3]];
  if (!isIn(...at)) return outside;
  const layer = clamped((above / k_height) * (k_layers - 1), 0, k_layers - 1);
  const one = (k) =>
    bilinear((i) => image[k * k_texels ** 2 + i] / 255, k_texels, k_texels, at[0], clamped(at[1], k_half, 1 - k_half));
  const lower = Math.floor(layer);
  return blended(one(lower), one(Math.min(lower + 1, k_layers - 1)), layer - lower);
}
function leftAt({ x, y, z }) {
  const hidden = layered(k_images.shadow, x - k_slide[0] * y, z - k_slide[1] * y, y, 0);
  const open = layered(k_images.occlusion, x, z, y, 1);
  const drawn = clamped(2 - Math.abs(y) / k_height, 0, 1);
  return 1 - drawn + drawn * (k_share * (1 - hidden) + (1 - k_share) * open);
}
const encoded = (c) => 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

// ---- What stands there

function things(THREE, book) {
  const slope = new THREE.BoxGeometry(0.2, 0.12, 0.14).translate(0, 0.06, 0);
  const { array } = slope.getAttribute("position");
  for (let i = 0; i < array.length; i += 3) if (array[i] < 0) array[i + 1] = 0;
  const shapes = [new THREE.PlaneGeometry(3, 3).rotateX(-Math.PI / 2), slope.translate(0.08, 0, 0.08)];
  if (book > 0) shapes.push(new THREE.BoxGeometry(0.17, book, 0.12).translate(-0.12, book / 2, -0.05));
  return shapes.map((shape) => new THREE.Mesh(shape, new THREE.MeshBasicMaterial({ side: THREE.DoubleSide })));
}
const heightOf = (book, x, z) => {
  const onSlope = Math.abs(x - 0.08) < 0.1 && Math.abs(z - 0.08) < 0.07 ? 0.6 * (x + 0.02) : 0;
  return Math.max(onSlope, Math.abs(x + 0.12) < 0.085 && Math.abs(z + 0.05) < 0.06 ? book : 0);
};
// Rays through the pixels, the lower row first, a metre long along the camera's axis; and where they end: there, or on the plane.
function seen(THREE, camera, meshes) {
  const caster = new THREE.Raycaster();
  const eye = camera.position.clone();
  const ahead = camera.getWorldDirection(new THREE.Vector3());
  return Array.from({ length: side ** 2 }, (_, i) => {
    const on = [(i % side) + 0.5, Math.floor(i / side) + 0.5].map((at) => (2 * at) / side - 1);
    const ray = new THREE.Vector3(...on, 0.5).unproject(camera).sub(eye);
    ray.divideScalar(ray.dot(ahead));
    caster.set(eye, ray.clone().normalize());
    const [met] = caster.intersectObjects(meshes);
    const metres = met?.point.sub(eye).dot(ahead) ?? Infinity;
    return { eye, ray, metres, place: eye.clone().addScaledVector(ray, met ? metres : -eye.y / ray.y) };
  });
}
// `turned`: rows are columns.
function imageOf(THREE, pixels, turned = false) {
  const metres = Float32Array.from({ length: side ** 2 }, (_, i) => {
    const [x, y] = [i % side, Math.floor(i / side)];
    const { metres } = turned ? pixels[(side - 1 - x) * side + y] : pixels[(side - 1 - y) * side + x];
    return metres < Infinity ? metres / k_bias : 0;
  });
  return numbersIn(THREE, metres, side);
}
const numbersIn = (THREE, numbers, columns) =>
  Object.assign(new THREE.DataTexture(numbers, columns, columns, THREE.RedFormat, THREE.FloatType), {
    needsUpdate: true,
  });
function heightsOf(THREE, book) {
  const low = -0.5 * k_cells * k_cell;
  const heights = Float32Array.from({ length: k_cells ** 2 }, (_, i) => {
    const [x, z] = [i % k_cells, Math.floor(i / k_cells)].map((cell) => low + k_cell * (cell + 0.5));
    return x < k_table ? heightOf(book, x, z) : k_gone;
  });
  const extent = k_cells * k_cell;
  const axes = { corner: [low, 0, low], along: [extent, 0, 0], across: [0, 0, extent], up: [0, 1, 0] };
  return { cells: [k_cells, k_cells], heights, ...axes };
}
// The place where a ray meets heights, by 24 steps from the highest down to the plane, and one linear step back; null: beyond their end.
function onHeights({ eye, ray }, held, highest) {
  const heightAt = ({ x, z }) => {
    const on = [x, z].map((at) => at / (k_cells * k_cell) + 0.5);
    return isIn(...on) ? bilinear((k) => held[k], k_cells, k_cells, ...on) : 0;
  };
  const last = -eye.y / ray.y;
  const first = (highest - eye.y) / ray.y;
  const at = (metres) => eye.clone().addScaledVector(ray, metres);
  let before;
  for (let i = 0; i <= 24; ++i) {
    const along = first + ((last - first) * i) / 24;
    const place = at(along);
    const over = place.y - heightAt(place);
    if (over < 0) return at(along - (((last - first) / 24) * over) / (over - before));
    before = over;
  }
  return heightAt(at(last)) > -1 ? at(last) : null;
}

// ---- Pictures

const k_ways = {
  image: ({ THREE, pixels }) => ({ depth: imageOf(THREE, pixels), metres: k_bias }),
  "a turned image": ({ THREE, pixels }) => ({
    depth: imageOf(THREE, pixels, true),
    metres: k_bias,
    fromView: [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
  }),
  "a depth buffer": ({ THREE, renderer, camera, meshes }) => ({ depth: bufferOf(THREE, renderer, camera, meshes) }),
  heights: ({ THREE, book }) => ({ heights: heightsOf(THREE, book) }),
  "an image without its factor": ({ THREE, pixels }) => ({ depth: imageOf(THREE, pixels), metres: 1 }),
  floor: () => ({}),
  "another camera": ({ THREE, camera, meshes }) => {
    const other = anotherCamera(camera);
    return { depth: imageOf(THREE, seen(THREE, other, meshes)), metres: k_bias, camera: other };
  },
  "another camera taken for the view's": (made) => ({ ...k_ways["another camera"](made), camera: null }),
};
// 4 cm and 5 degrees away.
function anotherCamera(camera) {
  const other = camera.clone();
  other.translateX(0.04);
  other.rotateY(0.087);
  other.updateMatrixWorld();
  return other;
}
function bufferOf(THREE, renderer, camera, meshes) {
  const own = new (renderer.isWebGLRenderer ? THREE.WebGLRenderTarget : THREE.RenderTarget)(side, side);
  own.depthTexture = Object.assign(new THREE.DepthTexture(side, side), { type: THREE.FloatType });
  const scene = new THREE.Scene();
  scene.add(...meshes);
  renderer.setRenderTarget(own);
  renderer.render(scene, camera);
  renderer.setRenderTarget(null);
  return own.depthTexture;
}
async function sceneOf(kind, options) {
  const made = await threeScene(kind, { change: (recorded) => ({ ...recorded, ...k_drawn }), ...options });
  made.group.visible = false;
  made.scene.background = new made.THREE.Color(0xffffff);
  return made;
}

// By each way, over a book of each height: which share of pixels is more than a byte's step off the formula, and which more than eight, at the
// true places or, by heights, at those where rays meet them.
export async function byDepth(kind, books) {
  const made = await sceneOf(kind);
  const { THREE, renderer, camera, stage, look } = made;
  const found = {};
  const receiver = stage.receiveByDepth();
  for (const book of books) {
    const meshes = things(THREE, book);
    for (const mesh of meshes) mesh.updateMatrixWorld();
    const pixels = seen(THREE, camera, meshes);
    const held = heightsOf(THREE, book).heights.map((x) =>
      THREE.DataUtils.fromHalfFloat(THREE.DataUtils.toHalfFloat(x)),
    );
    const highest = heightsOf(THREE, book).heights.reduce((most, x) => Math.max(most, x));
    for (const [way, options] of Object.entries(k_ways)) {
      const given = { depth: null, camera: null, heights: null, fromView: k_upright };
      receiver.set({ ...given, ...options({ THREE, renderer, camera, meshes, pixels, book }) });
      stage.update(1 / 60);
      const bytes = await look();
      const off = pixels.map((pixel, i) => {
        const place = way === "heights" ? onHeights(pixel, held, highest) : pixel.place;
        return Math.abs(bytes[4 * i] - encoded(place ? leftAt(place) : 1));
      });
      [1, 8].forEach((step, k) => {
        const share = off.filter((x) => x > step).length / off.length;
        found[way] ??= [0, 0];
        found[way][k] = Math.max(found[way][k], share);
      });
    }
  }
  done(renderer);
  return found;
}

// Of a thing before the floor, in the order in which all is drawn and as it is drawn after splats: its pixels that are darkened. And behind a canvas
// that is seen through, how far its alpha is from what the formula takes off.
export async function besideDepth(kind) {
  const made = await sceneOf(kind, { renderer: { alpha: true } });
  const { THREE, renderer, scene, camera, stage, look } = made;
  const meshes = things(THREE, 0);
  const pixels = seen(THREE, camera, meshes);
  const { mesh } = stage.receiveByDepth({ depth: imageOf(THREE, pixels), metres: k_bias });
  const thing = new THREE.Mesh(new THREE.BoxGeometry(0.2, 0.1, 0.2), new THREE.MeshBasicMaterial());
  scene.add(thing);
  scene.updateMatrixWorld();
  const its = seen(THREE, camera, [thing]).map(({ metres }) => metres < Infinity);
  stage.update(1 / 60);
  const dark = (bytes) => its.filter((is, i) => is && bytes[4 * i] < 254).length;
  const darkened = [dark(await look())];
  Object.assign(mesh, { renderOrder: 1 }).material.transparent = true;
  darkened.push(dark(await look()));
  thing.visible = false;
  const without = dark(await look());
  scene.background = null;
  stage.update(1 / 60);
  const bytes = await look();
  const alpha = pixels.reduce(
    (most, { place }, i) => Math.max(most, Math.abs(255 - bytes[4 * i + 3] - encoded(leftAt(place)))),
    0,
  );
  stage.dispose();
  done(renderer);
  return { darkened, without, alpha };
}

// A book that fills the picture rises, and nothing casts anew: by how many millimetres the shadow of a wall's upper edge has moved,
// by depth and without, and how often a shadow was made.
export async function slides(kind, heights, degrees) {
  const { THREE, renderer, scene, look, camera } = await sceneOf(kind);
  const stage = await createStage(THREE, { renderer, scene, height: k_height, budget: 1000 });
  const wall = new THREE.Mesh(
    new THREE.BoxGeometry(0.02, 0.3, 0.6).translate(0, 0.15, 0),
    new THREE.MeshBasicMaterial(),
  );
  await stage.addModel(wall, { collide: false });
  for (let i = 0; i < 60; ++i) stage.update(0.1);
  const angle = (degrees * Math.PI) / 180;
  stage.stage.shade([Math.sin(angle), Math.cos(angle), 0], new Array(64).fill(0), 0.1);
  const frameOf = stage.stage.frame.bind(stage.stage);
  let made = 0;
  stage.stage.frame = (seconds) => {
    const drawn = frameOf(seconds);
    made += drawn.textures.shadow ? 1 : 0;
    return { ...drawn, light: { ...k_light, ambient: new Array(27).fill(0) } };
  };
  do stage.update(0.1);
  while (stage.drawn.behind > 0);
  const before = made;
  const eye = 0.9;
  camera.position.set(-0.15, eye, 0);
  camera.up.set(0, 0, -1);
  camera.lookAt(-0.15, 0, 0);
  const receiver = stage.receiveByDepth();
  const edge = async (above) => {
    stage.update(1 / 60);
    const bytes = await look();
    const share = Array.from({ length: side }, (_, x) => (bytes[4 * (side * (side >> 1) + x)] / 255) ** 2.2);
    const half = 0.5 * (1 + Math.min(...share));
    const x = share.findIndex((one) => one < half);
    const at = x - (half - share[x]) / (share[x - 1] - share[x]);
    return 1000 * ((2 * (at + 0.5)) / side - 1) * Math.tan(camera.fov * (Math.PI / 360)) * (eye - above);
  };
  const onFloor = await edge(0);
  const floor = [];
  const found = [];
  for (const above of heights) {
    receiver.set({ depth: null });
    floor.push((await edge(0)) - onFloor);
    receiver.set({ depth: numbersIn(THREE, Float32Array.of(eye - above), 1), metres: 1 });
    found.push((await edge(above)) - onFloor);
  }
  stage.dispose();
  done(renderer);
  return { found, floor, made: [before, made - before] };
}

// The depth of meshes that only its camera sees.
function byDepthRenderer({ BABYLON, scene, camera }, z, meshes) {
  const eye = camera.clone("depth");
  eye.layerMask = 0x10000000;
  const list = meshes.map(({ geometry }) => {
    const mesh = new BABYLON.Mesh("", scene);
    mesh.setVerticesData("position", geometry.getAttribute("position").array);
    mesh.setIndices(Array.from(geometry.index.array));
    mesh.material = Object.assign(new BABYLON.StandardMaterial("", scene), { backFaceCulling: false });
    mesh.scaling.z = z;
    mesh.layerMask = eye.layerMask;
    return mesh;
  });
  const map = scene.enableDepthRenderer(eye, false, true, 1, true).getDepthMap();
  map.renderList = list;
  return map;
}
// The same in Babylon.js, whose picture is encoded by a power; and by its own depth renderer.
export async function babylonByDepth(kind, left, books) {
  const THREE = await import("three");
  const made = await babylonScene(kind, left);
  const { BABYLON, engine, scene, stage, look, occluder } = made;
  const { eye, target } = frame.scenes[frame.first];
  const camera = new THREE.PerspectiveCamera(40, 1, 0.05, 20);
  camera.position.set(...eye);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  scene.clearColor = new BABYLON.Color4(1, 1, 1, 1);
  stage.sand.root.setEnabled(false);
  occluder.isVisible = false;
  stage.stage = frame.replay({ ...(await frame.recorded()), ...k_drawn });
  const receiver = stage.receiveByDepth();
  const found = {};
  for (const book of books) {
    const meshes = things(THREE, book);
    for (const mesh of meshes) mesh.updateMatrixWorld();
    const pixels = seen(THREE, camera, meshes);
    const metres = imageOf(THREE, pixels).image.data;
    const image = BABYLON.RawTexture.CreateRTexture(metres, side, side, scene, false, false, 1, 1);
    const { heights } = k_ways.heights({ THREE, book });
    const held = heights.heights.map((x) => BABYLON.FromHalfFloat(BABYLON.ToHalfFloat(x)));
    const highest = held.reduce((most, x) => Math.max(most, x));
    for (const [way, options] of Object.entries({
      image: { depth: image, metres: k_bias },
      "a depth renderer": { depth: byDepthRenderer(made, left ? -1 : 1, meshes), metres: 1 },
      heights: { heights },
      floor: {},
    })) {
      receiver.set({ depth: null, heights: null, ...options });
      stage.update(1 / 60);
      const bytes = await shown(scene, look);
      const off = pixels.map((pixel, i) => {
        const place = way === "heights" ? onHeights(pixel, held, highest) : pixel.place;
        return Math.abs(bytes[4 * i] - 255 * (place ? leftAt(place) : 1) ** (1 / 2.2));
      });
      [1, 8].forEach((step, k) => {
        const share = off.filter((x) => x > step).length / off.length;
        found[way] ??= [0, 0];
        found[way][k] = Math.max(found[way][k], share);
      });
    }
    image.dispose();
  }
  engine.dispose();
  return found;
}
