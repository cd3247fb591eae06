// What an engine's objects, cameras and vectors become, and what is promised is answered: three.js and Babylon.js under node,
// without WebGL.
// node objects_test.mjs NPM_FOLDER ENGINES_FOLDER    ENGINES_FOLDER has node_modules.
import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";
const [npm, engines] = process.argv.slice(2);
const THREE = await import(pathToFileURL(`${engines}/node_modules/three/build/three.module.js`));
const BABYLON = await import(pathToFileURL(`${engines}/node_modules/@babylonjs/core/index.js`));
const { createStage } = await import(pathToFileURL(`${npm}/three.mjs`));
const { createStage: createBabylonStage } = await import(pathToFileURL(`${npm}/babylon.mjs`));
const { WorkerStage, fieldMade } = await import(pathToFileURL(`${npm}/worker.mjs`));
const { depthOf, handJoints } = await import(pathToFileURL(`${npm}/webxr.mjs`));
const { isSolid } = await import(pathToFileURL(`${npm}/stage_place.mjs`));
const { checkedMesh } = await import(pathToFileURL(`${npm}/mesh_field.mjs`));
const { text } = await import(pathToFileURL(`${npm}/worker_text.mjs`));

const warned = [];
const told = [];
console.warn = (sentence) => warned.push(sentence);
console.error = (sentence) => told.push(sentence);
const threeStage = (scene = new THREE.Scene(), options = {}) =>
  createStage(THREE, { renderer: { isWebGLRenderer: true }, scene, ...options });

// How many triangles, and how far they reach along x.
function taken(stage, object) {
  const { positions, indices } = stage.meshOf(object, stage.poseOf(object));
  const xs = [...indices].map((i) => positions[3 * i]);
  return [indices.length / 3, ...[Math.min, Math.max].map((most) => +xs.reduce((a, b) => most(a, b)).toFixed(2))];
}

async function takesWhatIsSeen() {
  const stage = await threeStage();
  const geometry = (side = 0.1) => new THREE.BoxGeometry(side, side, side);
  const box = (side) => new THREE.Mesh(geometry(side));
  const hidden = (object) => Object.assign(object, { visible: false });
  const sides = [-1, 1, 2, 3].map((x) => new THREE.Matrix4().makeTranslation(x, 0, 0));
  const instanced = new THREE.InstancedMesh(geometry(), undefined, 4);
  const batched = new THREE.BatchedMesh(5, 200, 400);
  const kinds = [0.3, 0.1].map((side) => batched.addGeometry(geometry(side)));
  const ids = sides.map((matrix, i) => {
    const id = batched.addInstance(kinds[i === 2 ? 0 : 1]);
    batched.setMatrixAt(id, matrix);
    instanced.setMatrixAt(i, matrix);
    return id;
  });
  batched.deleteInstance(ids[2]);
  batched.setVisibleAt(ids[3], false);
  instanced.count = 2;
  const ranged = box();
  ranged.geometry.setDrawRange(0, 6); // its right side
  const lod = new THREE.LOD().addLevel(box(), 0).addLevel(box(3), 5);
  const line = Object.assign(box(4), { geometry: new THREE.InstancedBufferGeometry().copy(geometry(4)) });
  for (const [object, is] of [
    [box(), [12, -0.05, 0.05]],
    [hidden(box()), [12, -0.05, 0.05]],
    [new THREE.Group().add(box(), hidden(box(5)), hidden(new THREE.Group().add(box(6)))), [12, -0.05, 0.05]],
    [lod, [12, -0.05, 0.05]],
    [ranged, [2, 0.05, 0.05]],
    [new THREE.Group().add(box(), new THREE.Mesh(), new THREE.Line(geometry(4)), line), [12, -0.05, 0.05]],
    [instanced, [24, -1.05, 1.05]],
    [batched, [24, -1.05, 1.05]],
  ])
    assert.deepEqual(taken(stage, object), is, object.type);
}

// A child that is turned in a stretched group is sheared: by the pose, and from its mesh, its vertices are where they are seen.
async function takesWhatIsSheared() {
  const stage = await threeStage();
  const child = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.1, 0.1));
  child.rotation.set(0.3, 0.2, 0.7);
  const group = new THREE.Group().add(child);
  group.scale.x = 3;
  const pose = stage.poseOf(child);
  const { positions } = stage.meshOf(child, pose);
  const places = child.geometry.getAttribute("position");
  const turn = new THREE.Quaternion(...pose.rotation).normalize();
  for (let i = 0; i < places.count; ++i) {
    const seen = new THREE.Vector3().fromBufferAttribute(places, i).applyMatrix4(child.matrixWorld);
    const taken = new THREE.Vector3().fromArray(positions, 3 * i).applyQuaternion(turn);
    assert.ok(taken.add(new THREE.Vector3(...pose.position)).distanceTo(seen) < 1e-6);
  }
}

// What stands for a place stands where it does, and is drawn before all else.
async function babylonPlace(stage, scene, tilted) {
  tilted.rotation.set(0.3, 0.2, 0.1);
  tilted.position.set(0.3, 0.1, 0.2);
  const bounds = ({ minimumWorld, maximumWorld }) => [...minimumWorld.asArray(), ...maximumWorld.asArray()];
  tilted.computeWorldMatrix(true);
  const was = bounds(tilted.getBoundingInfo().boundingBox);
  const place = await stage.addPlace(tilted);
  const veil = scene.meshes.slice(-2);
  for (const mesh of veil) {
    mesh.computeWorldMatrix(true);
    mesh.refreshBoundingInfo();
    const now = bounds(mesh.getBoundingInfo().boundingBox);
    assert.ok(
      now.every((x, i) => Math.abs(x - was[i]) < 1e-4),
      `${now}, not ${was}`,
    );
  }
  assert.deepEqual(
    [tilted.isEnabled(), veil[0].material.disableColorWrite, veil[0].material.uniqueId < 0],
    [false, true, true],
  );
  stage.update(0.1);
  await place.dispose();
  assert.deepEqual([tilted.isEnabled(), veil.some((mesh) => scene.meshes.includes(mesh))], [true, false]);
}

// The engine draws nothing here; textures are counted.
async function babylonTakes(right) {
  const engine = new BABYLON.NullEngine();
  Object.defineProperty(engine, "webGLVersion", { value: 2 });
  engine.getCaps().instancedArrays = true;
  const scene = new BABYLON.Scene(engine);
  scene.useRightHandedSystem = right;
  let textures = 0;
  class Texture {
    static CreateRTexture = () => new Texture();
    constructor() {
      ++textures;
    }
    getSize = () => ({ width: 0 });
    getInternalTexture = () => ({});
    dispose() {
      --textures;
    }
  }
  const stage = await createBabylonStage(
    { ...BABYLON, RawTexture: Texture, RawCubeTexture: Texture, RawTexture3D: Texture },
    { scene },
  );
  const box = (size, parent = null, hidden = {}) =>
    Object.assign(BABYLON.CreateBox("", { size }, scene), { parent, ...hidden });
  const root = box(0.1, null, { isVisible: false });
  box(5, root).setEnabled(false);
  box(6, root, { isVisible: false });
  BABYLON.CreateLines("", { points: [0, 9].map((x) => new BABYLON.Vector3(x, 1, 0)) }, scene).parent = root;
  assert.deepEqual(taken(stage, root), [12, -0.05, 0.05]);
  const thin = box(0.1);
  thin.thinInstanceAdd([-1, 1].map((x) => BABYLON.Matrix.Translation(x, 0, 0)));
  assert.deepEqual(taken(stage, thin), [24, -1.05, 1.05]);

  const camera = new BABYLON.FreeCamera("", BABYLON.Vector3.Zero(), scene);
  const sees = () => {
    const { diagonal, centre } = stage.cameraOf(camera);
    return [diagonal, ...centre].map((x) => +x.toFixed(1) + 0);
  };
  camera.fov = Math.PI / 2;
  assert.deepEqual(sees(), [131.8, 0, 0]); // the engine shows 512 x 256
  camera.fovMode = BABYLON.Camera.FOVMODE_HORIZONTAL_FIXED;
  assert.deepEqual(sees(), [96.4, 0, 0]);
  const z = right ? -1 : 1;
  const tracked = { 0: 2, 5: 2, 8: -0.4 * z, 10: z, 11: z, 14: -0.1 };
  camera.freezeProjectionMatrix(BABYLON.Matrix.FromArray(Array.from({ length: 16 }, (_, i) => tracked[i] ?? 0)));
  assert.deepEqual(sees(), [70.5, 0.4, 0]);
  camera.unfreezeProjectionMatrix();
  camera.mode = BABYLON.Camera.ORTHOGRAPHIC_CAMERA;
  assert.throws(sees, /needs a camera with perspective/);

  await stage.createSand({ particles: 50 });
  stage.pour({ position: new BABYLON.Vector3(0, 0.3, 0), rotation: BABYLON.Quaternion.Identity() });
  stage.push({ position: new BABYLON.Vector3(0, 0.1, 0), radius: 0.02 });
  await stage.addModel(thin);
  await babylonPlace(stage, scene, box(0.2, root));
  stage.dispose();
  assert.equal(textures, 0);
  engine.dispose();
}

async function takesCameras() {
  const stage = await threeStage();
  const aspect = 4 / 3;
  const by_fov = new THREE.PerspectiveCamera(35, aspect);
  const half = Math.tan((35 * Math.PI) / 360);
  const zoomed = Object.assign(by_fov.clone(), { zoom: 2 });
  const shifted = Object.assign(by_fov.clone(), { filmOffset: 7 });
  const quarter = by_fov.clone();
  for (const camera of [zoomed, shifted]) camera.updateProjectionMatrix();
  quarter.setViewOffset(800, 600, 400, 0, 400, 300);
  const [tracked, plain] = [new THREE.PerspectiveCamera(), new THREE.Camera()];
  for (const camera of [tracked, plain]) camera.projectionMatrix.copy(by_fov.projectionMatrix);
  for (const [camera, up, centre] of [
    [by_fov, half, [0, 0]],
    [tracked, half, [0, 0]],
    [plain, half, [0, 0]],
    [zoomed, half / 2, [0, 0]],
    [shifted, half, [0.475739, 0]], // a fifth of the film of 35 mm
    [quarter, half / 2, [1, 1]],
  ]) {
    const told_of = stage.cameraOf(camera);
    const diagonal = (360 / Math.PI) * Math.atan(up * Math.hypot(1, aspect));
    assert.ok(Math.abs(told_of.diagonal - diagonal) < 1e-6, `${told_of.diagonal}, not ${diagonal}`);
    for (const k of [0, 1]) assert.ok(Math.abs(told_of.centre[k] - centre[k]) < 1e-5);
  }
  const picture = { data: new Uint8Array(4 * 64 * 48).fill(90), width: 64, height: 48 };
  await stage.see(picture, quarter);
  // A headset's camera, by its lens and its place on the headset, is the engine's camera there.
  const headset = new THREE.Group().add(shifted);
  headset.position.set(0.3, 1.6, -0.2);
  headset.rotation.set(0.2, -0.7, 0.1);
  shifted.position.set(0.03, 0.01, -0.05);
  shifted.rotation.set(-0.3, 0.1, 0.05);
  const { 0: px, 5: py, 8: right, 9: above } = shifted.projectionMatrix.elements;
  const lens = { focal: [32 * px, 24 * py], centre: [(1 - right) * 32 - 0.5, (1 + above) * 24 - 0.5] };
  const onHeadset = { position: shifted.position, orientation: shifted.quaternion };
  const { position: p, quaternion: q } = headset;
  const viewer = { position: { x: p.x, y: p.y, z: p.z, w: 1 }, orientation: { x: q.x, y: q.y, z: q.z, w: q.w } };
  const seen = [];
  stage.stage.see = (_, view) => seen.push(view);
  await stage.see(picture, shifted);
  await stage.seeThrough(picture, viewer, { ...lens, ...onHeadset });
  await stage.seeThrough(picture, viewer, lens); // control: a camera in the middle of the headset
  const far = (view) =>
    Math.max(
      ...["position", "orientation", "centre"].flatMap((of) => seen[0][of].map((x, k) => Math.abs(x - view[of][k]))),
    );
  assert.ok(far(seen[1]) < 1e-6 && Math.abs(seen[1].diagonal - seen[0].diagonal) < 1e-6, JSON.stringify(seen));
  assert.ok(far(seen[2]) > 0.05);
  await assert.rejects(stage.seeThrough(picture, viewer, { centre: [1, 1] }), /seeThrough: focal must be 2 numbers/);
  await assert.rejects(stage.seeThrough(picture, null, lens), /where the viewer was then: an XRRigidTransform/);
}

// How many texels of the model's shadow are dark after some frames; nothing is drawn anew where it is as before.
let dark;
function shadow(stage) {
  for (let i = 0; i < 30; ++i) {
    stage.update(1 / 60);
    const { occlusion } = stage.drawn.textures;
    if (occlusion) dark = occlusion.bytes.filter((byte) => byte < 128).length;
  }
  return dark > 0;
}

async function followsWhatIsSeen() {
  const scene = new THREE.Scene();
  const stage = await threeStage(scene);
  const part = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.3, 0.1));
  const model = new THREE.Group().add(part);
  const switched = (visible) => {
    model.visible = visible;
    return shadow(stage);
  };
  scene.add(model);
  model.visible = false;
  await stage.addModel(model, { collide: false });
  assert.ok(shadow(stage), "a model that stands for a real thing casts");
  assert.deepEqual([true, false, true].map(switched), [true, false, true]);
  model.removeFromParent();
  assert.ok(!shadow(stage), "a model out of the scene casts");
  scene.add(model);
  model.position.x = NaN; // a tracker has lost it
  assert.ok(shadow(stage), "a model without a pose is gone");
  model.position.x = 1;
  model.rotation.y = 1;
  stage.update(1 / 60);
  const lost = new THREE.Group();
  lost.position.y = NaN;
  await assert.rejects(stage.addModel(lost), /has no finite pose\. Set its position/);
  assert.deepEqual(warned, []);
  part.position.x = 0.2;
  shadow(stage);
  assert.match(warned.pop(), /parts of a model move.*removeModel and addModel/);

  const skinned = new THREE.SkinnedMesh(part.geometry.clone());
  const bone = new THREE.Bone();
  const weights = new THREE.BufferAttribute(new Float32Array(96).fill(0.25), 4);
  const indices = new THREE.BufferAttribute(new Uint16Array(96), 4);
  skinned.geometry.setAttribute("skinIndex", indices).setAttribute("skinWeight", weights);
  skinned.add(bone).bind(new THREE.Skeleton([bone]));
  const other = await threeStage(scene);
  scene.add(skinned);
  await other.addModel(skinned, { collide: false });
  skinned.position.x = 0.3;
  shadow(other);
  assert.deepEqual(warned, []);
  bone.position.y = 0.1;
  shadow(other);
  assert.match(warned.pop(), /parts of a model move/);
}

async function isAddedOnce() {
  const scene = new THREE.Scene();
  const stage = await threeStage(scene);
  const model = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.1, 0.1));
  const children = scene.children.length;
  await stage.addModel(model);
  await assert.rejects(stage.addModel(model), /has this object already\. Call removeModel/);
  await stage.removeModel(model);
  await assert.rejects(stage.removeModel(model), /removeModel takes an object/);
  await stage.addModel(model);
  for (let i = 0; i < 2; ++i) {
    await stage.createSand({ particles: 50 });
    assert.equal(scene.children.length, children + 1);
  }
  const begun = stage.createSand({ particles: 50 });
  stage.dispose();
  await assert.rejects(begun, /dispose or end was called\. Create another/);
  assert.equal(scene.children.length, 0);
  for (const call of ["addModel", "see", "createSand"])
    await assert.rejects(stage[call](model), /dispose or end was called/);
  for (const call of ["pour", "push"]) assert.throws(() => stage[call](), /dispose or end was called/);
  stage.update();
  stage.dispose();
}

// What is closed is solid, however it is turned, mirrored and stretched, its seams and poles too; a room's walls are not, seen from
// within, nor is what has a hole.
async function tellsWhatIsSolid() {
  const stage = await threeStage();
  for (const [geometry, is] of [
    [new THREE.SphereGeometry(0.2, 64, 32), true],
    [new THREE.CylinderGeometry(0.2, 0.1, 0.3, 48), true],
    [new THREE.TorusKnotGeometry(0.2, 0.05, 200, 32), true],
    [new THREE.IcosahedronGeometry(0.2, 5), true],
    [new THREE.CylinderGeometry(0.2, 0.1, 0.3, 48, 1, true), false],
    [new THREE.SphereGeometry(0.2, 64, 32, 0, 6), false],
    [new THREE.PlaneGeometry(1, 1), false],
    [new THREE.BoxGeometry(5, 3, 5).scale(-1, 1, 1), false],
  ]) {
    const mesh = new THREE.Mesh(geometry);
    mesh.rotation.set(0.3, 0.7, 1.1);
    mesh.scale.set(1, 2, -0.7);
    const group = new THREE.Group().add(mesh);
    assert.equal(isSolid(checkedMesh(stage.meshOf(group, stage.poseOf(group)))), is, geometry.type);
  }
}

// A place is hidden, and something stands for it that hides and receives, where it stands; withdrawn, all is as before.
async function takesPlaces() {
  const scene = new THREE.Scene();
  const stage = await threeStage(scene);
  const before = scene.children.length;
  const table = new THREE.Mesh(new THREE.CylinderGeometry(0.2, 0.2, 0.1, 24));
  const group = new THREE.Group().add(table);
  group.scale.set(2, 1, -1);
  group.rotation.set(0, 0.3, 0);
  group.position.x = 0.1;
  scene.add(group);
  const place = await stage.addPlace(group);
  assert.equal(stage.stage.relief, 0, "a closed mesh is no height");
  const veil = scene.children.at(-1);
  const [hides, receives] = veil.children;
  assert.deepEqual([group.visible, scene.children.length], [false, before + 2]);
  const is = ({ material, renderOrder }) => [
    material.colorWrite,
    material.depthWrite,
    material.transparent,
    renderOrder < 0,
  ];
  assert.deepEqual([hides, receives].map(is), [
    [false, true, false, true],
    [true, false, true, true],
  ]);
  const box = (object) => new THREE.Box3().setFromObject(object, true);
  const same = (a, b) => assert.ok(a.min.distanceTo(b.min) + a.max.distanceTo(b.max) < 1e-5, "it stands elsewhere");
  same(box(veil), box(group));
  await assert.rejects(stage.addPlace(group), /addPlace has this object already\. Call removeModel first/);
  group.position.set(0.3, 0.2, 0);
  stage.update(1 / 60);
  same(box(veil), box(group));
  table.geometry = new THREE.PlaneGeometry(0.4, 0.4).rotateX(-Math.PI / 2);
  await place.update();
  assert.notEqual(stage.stage.relief, 0, "an open mesh is no height");
  assert.deepEqual([veil.parent, scene.children.length], [null, before + 2]);
  same(box(scene.children.at(-1)), box(group));
  await Promise.all([place.update(), place.update()]);
  assert.equal(scene.children.length, before + 2);
  table.geometry = new THREE.BufferGeometry();
  await assert.rejects(place.update(), /no triangles/);
  assert.deepEqual([group.visible, scene.children.length], [false, before + 2]);
  table.geometry = new THREE.PlaneGeometry(0.4, 0.4);
  await Promise.all([place.update(), place.dispose()]);
  await place.dispose();
  table.geometry = new THREE.BufferGeometry();
  await assert.rejects(place.update(), /has been withdrawn\. Call addPlace/);
  assert.deepEqual([group.visible, scene.children.length], [true, before + 1]);
  await assert.rejects(stage.addPlace(group), /no triangles/);
  assert.ok(group.visible);
  table.geometry = new THREE.BoxGeometry(0.1, 0.1, 0.1);
  const adding = stage.addPlace(group);
  stage.removeModel(group); // before it is added
  await Promise.all([adding, stage.addPlace(group)]);
  assert.deepEqual([group.visible, scene.children.length], [false, before + 2]);
  await stage.removeModel(group);
  assert.deepEqual([group.visible, scene.children.length], [true, before + 1]);
  await stage.addPlace(group);
  stage.dispose();
  assert.deepEqual([group.visible, scene.children.length], [true, 1]);
}

// An emulated device: hands of 25 joints, the second lost; and depth of a phone held upright, whose image is turned by 90 degrees
// and wider than the view. A pixel's ray is that which WebXR says by its two matrices.
async function takesWebXR() {
  const joint = (x) => ({ x });
  const handOf = (handedness) => ({ handedness, hand: new Map(Array.from({ length: 25 }, (_, i) => [i, joint(i)])) });
  const frame = {
    session: { inputSources: [{ handedness: "none" }, handOf("right"), handOf("left")] },
    getJointPose: ({ x }, space) =>
      space === lost && x === 7 ? null : { radius: 0.01, transform: { position: { x, y: 1, z: 0, w: 1 } } },
  };
  const lost = {};
  assert.deepEqual(
    handJoints(frame, {}).map((hand) => [hand.length, hand[7].position.x, hand[7].radius]),
    [
      [25, 7, 0.01],
      [25, 7, 0.01],
    ],
  );
  assert.deepEqual(handJoints(frame, lost), [null, null]);
  frame.session.inputSources.pop();
  assert.deepEqual(handJoints(frame, {}).map(Boolean), [false, true]);

  const turn = new THREE.Quaternion().setFromEuler(new THREE.Euler(-0.5, 0.4, 0.1));
  const { x, y, z, w } = turn;
  const camera = new THREE.PerspectiveCamera(50, 0.5);
  camera.setViewOffset(100, 200, 4, -6, 100, 200); // not in the middle
  const projectionMatrix = camera.projectionMatrix.elements;
  const view = { projectionMatrix, transform: { position: { x: 0.1, y: 1, z: 0, w: 1 }, orientation: { x, y, z, w } } };
  const matrix = (...m) => ({ matrix: Float32Array.of(...m) });
  // Columns of the view's (u, v): the image's width runs down the view, and its height to the left.
  const upright = matrix(0, -0.8, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0.9, 0, 1);
  const straight = matrix(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  const depth = { width: 16, height: 9, rawValueToMeters: 0.001, data: new ArrayBuffer(288) };
  for (const normDepthBufferFromNormView of [upright, straight]) {
    const taken = depthOf({ ...depth, normDepthBufferFromNormView }, view);
    const inView = new THREE.Matrix4().fromArray(normDepthBufferFromNormView.matrix).invert();
    const back = new THREE.Matrix4().fromArray(projectionMatrix).invert();
    for (const [column, row] of [
      [0, 0],
      [15, 0],
      [3, 8],
    ]) {
      const at = new THREE.Vector3((column + 0.5) / 16, (row + 0.5) / 9, 0).applyMatrix4(inView);
      const ray = new THREE.Vector3(2 * at.x - 1, 1 - 2 * at.y, 0).applyMatrix4(back).normalize().applyQuaternion(turn);
      const own = new THREE.Vector3(
        (column - taken.centre[0]) / taken.focal[0],
        (taken.centre[1] - row) / taken.focal[1],
        -1,
      );
      own.normalize().applyQuaternion(new THREE.Quaternion(...taken.orientation));
      assert.ok(own.distanceTo(ray) < 1e-5, `${column}, ${row}: ${own.toArray()}, not ${ray.toArray()}`);
    }
    assert.deepEqual([taken.data.constructor, taken.data.length, taken.toMetres], [Uint16Array, 144, 0.001]);
  }
  const own = { projectionMatrix, transform: { ...view.transform, position: { x: 9, y: 0, z: 0, w: 1 } } };
  const floats = { ...depth, ...own, data: new ArrayBuffer(576), normDepthBufferFromNormView: straight };
  assert.deepEqual([depthOf(floats, view).position, depthOf(floats, view).data.constructor], [[9, 0, 0], Float32Array]);
  const texture = { ...depth, data: undefined, texture: {}, normDepthBufferFromNormView: straight };
  assert.throws(
    () => depthOf(texture, view),
    /cannot read a texture\. Ask the session.*cpu-optimized, or read it back/,
  );
  assert.throws(() => depthOf({ ...depth, data: new ArrayBuffer(9) }, view), /with 2 or 4 bytes a pixel/);
  const mirrored = matrix(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1);
  const turned = { ...depth, normDepthBufferFromNormView: mirrored };
  assert.throws(() => depthOf(turned, view), /not mirrored or sheared/);
  const stage = await threeStage();
  await stage.seeDepth(null, view);
  assert.equal(stage.stage.relief, 0);
  await stage.seeDepth(floats, view);
  assert.notEqual(stage.stage.relief, 0);
  await stage.seeHands(frame, {});
  await stage.seeHands();
}

// An emulated room: its meshes, or its planes, are places as long as they are told of. One that is lost stays.
async function takesARoom() {
  const scene = new THREE.Scene();
  const stage = await threeStage(scene);
  const empty = scene.children.length;
  const box = new THREE.BoxGeometry(0.4, 0.2, 0.4);
  const mesh = (at) => ({
    meshSpace: at,
    vertices: box.getAttribute("position").array,
    indices: Uint32Array.from(box.index.array),
    lastChangedTime: 1,
  });
  const pose = ([x, y, z]) => ({ transform: { position: { x, y, z, w: 1 }, orientation: { x: 0, y: 0, z: 0, w: 1 } } });
  const corners = [
    [-1, -1],
    [-1, 1],
    [1, 1],
    [1, -1],
  ].map(([x, z]) => ({ x: x / 5, y: 0, z: z / 5 }));
  const plane = { planeSpace: [0, 0.3, 0], polygon: corners, lastChangedTime: 1 };
  const [one, other] = [mesh([0, 0.1, 0]), mesh([1, 0.1, 0])];
  const room = {
    detectedMeshes: new Set([one, other]),
    detectedPlanes: new Set([plane]),
    getPose: (at) => at && pose(at),
  };
  const settled = async () => {
    await stage.seeRoom(room, {});
    for (let i = 0; i < 20; ++i) await new Promise((done) => setTimeout(done));
    stage.update(1 / 60);
    return scene.children.slice(empty).map(({ position }) => position.toArray());
  };
  assert.deepEqual(await settled(), [one.meshSpace, other.meshSpace]);
  assert.equal(stage.stage.relief, 0, "a box is solid");
  one.meshSpace = null;
  other.meshSpace = [1, 0.2, 0];
  assert.deepEqual(await settled(), [
    [0, 0.1, 0],
    [1, 0.2, 0],
  ]);
  room.detectedMeshes.delete(one);
  assert.deepEqual(await settled(), [[1, 0.2, 0]]);
  const [veil] = scene.children.slice(empty);
  Object.assign(other, { lastChangedTime: 2, indices: other.indices.slice(6) });
  assert.deepEqual(await settled(), [[1, 0.2, 0]]);
  assert.notEqual(stage.stage.relief, 0, "an open box is solid");
  assert.equal(veil.parent, null);
  room.detectedMeshes.clear();
  assert.deepEqual(await settled(), [plane.planeSpace]);
  const { array } = scene.children[empty].children[0].geometry.index;
  assert.deepEqual([...array], [0, 1, 2, 0, 2, 3]);
  room.detectedPlanes.clear();
  assert.deepEqual(await settled(), []);
  stage.dispose();
}

// Workers that answer at once, never, or that the page's policy forbids.
async function answersFromWorkers() {
  const workers = [];
  let how = "forbidden";
  globalThis.location = { href: "http://127.0.0.1/an_apps_worker.js" };
  globalThis.Worker = class {
    constructor(url) {
      this.sent = [];
      workers.push(Object.assign(this, { url }));
      if (how === "forbidden") setTimeout(() => this.onerror({}));
    }
    postMessage({ id, command, values = [] }) {
      const [name] = values;
      this.sent.push(structuredClone([command, ...(command === "create" ? values.slice(1) : values)]));
      if (how === "at once" || command === "block")
        queueMicrotask(() => this.onmessage({ data: { id, result: name === "addModel" ? 5 : {} } }));
    }
    terminate() {
      this.ended = true;
    }
  };
  const sentence = /^Error: sandglass: a worker does not run\. Allow worker-src blob:/;
  await assert.rejects(threeStage(new THREE.Scene(), { worker: true }), sentence);
  for (let i = 0; i < 2; ++i) await assert.rejects(fieldMade({}, {}, 1), sentence);
  assert.equal(workers.length, 3, "a dead worker is kept");

  how = "at once"; // an app's own worker has no document, either
  const stage = await threeStage(new THREE.Scene(), { worker: true, origin: new THREE.Vector3(0, 1, 0) });
  const { url, sent } = workers.at(-1);
  assert.match(url, /^blob:/);
  assert.match(text, /k_own_worker = true/);
  assert.deepEqual(sent.pop()[1].origin, [0, 1, 0]);

  const at = new THREE.Vector3(0, 0.5, 0);
  const one = { position: [0, 0.5, 0], radius: 0.1 };
  await stage.pour({ ...one, position: at, rotation: new THREE.Quaternion() });
  assert.deepEqual(sent.pop()[2], [{ ...one, rotation: [0, 0, 0, 1] }]);
  await stage.push({ ...one, position: new BABYLON.Vector3(0, 0.5, 0), velocity: at });
  assert.deepEqual(sent.pop()[2], [{ ...one, velocity: [0, 0.5, 0] }]);
  await assert.rejects(stage.push({ ...one, speed: 1 }), /a ball takes no "speed"/);
  const model = new THREE.Mesh(new THREE.BoxGeometry(0.1, 0.1, 0.1));
  const adding = stage.addModel(model);
  await stage.removeModel(model);
  await adding;
  assert.deepEqual(sent.filter(([, name]) => name === "remove").pop(), ["stage", "remove", [5]]);

  (await threeStage(new THREE.Scene(), { threads: 2 })).dispose();
  assert.ok(workers.at(-1).ended, "a thread goes on");

  how = "never";
  const waiting = [stage.createSand(), stage.addModel(model)];
  stage.update();
  stage.dispose();
  await Promise.all(waiting.map((one) => assert.rejects(one, /dispose or end was called\. Create another/)));
  assert.ok(workers[3].ended);
  await assert.rejects(stage.stage.frame(0.1), /dispose or end was called/);
  await stage.removeModel(model);

  delete globalThis.Worker;
  await assert.rejects(WorkerStage.create(), /no workers here.*\. Take Stage/);
  delete globalThis.location;
}

await takesWhatIsSeen();
await takesWhatIsSheared();
for (const right of [true, false]) await babylonTakes(right);
await takesCameras();
await followsWhatIsSeen();
await isAddedOnce();
await tellsWhatIsSolid();
await takesPlaces();
await takesWebXR();
await takesARoom();
await answersFromWorkers();
assert.deepEqual(told, []);
console.log("objects, cameras and vectors of two engines are taken, and all promises answered");
process.exit(0);
