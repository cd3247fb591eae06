// sandglass/babylon: a stage in a scene of Babylon.js, right-handed or left-handed, which the app hands over; nothing is
// imported of it. In a left-handed scene the stage's z is the scene's -z.
import { Engine, oneMesh } from "./engine.mjs";
import { checked } from "./options.mjs";
import { frustumOf } from "./place_light.mjs";
import { BabylonDepthReceiver } from "./babylon_depth.mjs";
import { BabylonReceiver } from "./babylon_receive.mjs";
import { BabylonSand } from "./babylon_sand.mjs";

// `scene` is needed; `worker`: the stage runs in a Worker; else options of Stage.create.
export async function createStage(BABYLON, { scene, ...options } = {}) {
  const engine = scene?.getEngine();
  if (!(engine?.webGLVersion >= 2) && !engine?.isWebGPU)
    throw new Error(
      "sandglass: createStage needs a scene of an Engine with WebGL 2, or of a WebGPUEngine. Pass { scene: new Scene(new Engine(canvas)) }.",
    );
  return new BabylonStage(BABYLON, scene, await Engine.stageOf(options));
}

class BabylonStage extends Engine {
  constructor(BABYLON, scene, stage) {
    super(stage);
    Object.assign(this, {
      BABYLON,
      scene,
      z: scene.useRightHandedSystem ? 1 : -1,
      sun: new BABYLON.DirectionalLight("sandglass", new BABYLON.Vector3(0, -1, 0), scene),
      byDepth: new Set(),
      placing: "computeWorldMatrix",
    });
    // The engine takes harmonics from a cube map; this one is black, so that nothing is reflected.
    this.around = new BABYLON.RawCubeTexture(
      scene,
      Array.from({ length: 6 }, () => new Uint8Array([0, 0, 0, 255])),
      1,
    );
    scene.getEngine().getLoadedTexturesCache().push(this.around.getInternalTexture()); // so that it outlives its context
    scene.environmentTexture ??= this.around;
    this.receiver = new BabylonReceiver(BABYLON, scene, this.z);
  }
  mirrored([x, y, z]) {
    return [x, y, this.z * z];
  }

  poseOf(object) {
    const { Vector3, Quaternion } = this.BABYLON;
    const position = new Vector3();
    const rotation = new Quaternion();
    object.computeWorldMatrix(true).decompose(new Vector3(), rotation, position);
    rotation.normalize(); // of what is sheared it has another length
    return {
      position: this.mirrored(position.asArray()),
      rotation: [this.z * rotation.x, this.z * rotation.y, rotation.z, rotation.w],
    };
  }
  isShown(object) {
    return !object.isDisposed() && object.isEnabled() && object.isVisible !== false && object.getScene() === this.scene;
  }
  // The meshes of an object that are seen where it is: no hidden child, and no lines.
  meshesOf(object) {
    const isSeen = (mesh) => {
      let one = mesh;
      for (; one !== object && one.isEnabled(false); one = one.parent);
      return one === object && mesh.isVisible;
    };
    return [object, ...object.getChildMeshes(false).filter(isSeen)].filter(
      (mesh) => mesh.getTotalVertices?.() && !/Lines/.test(mesh.getClassName()),
    );
  }
  toStageOf({ position, rotation }) {
    const { Vector3, Matrix, Quaternion } = this.BABYLON;
    const pose = Matrix.Compose(Vector3.One(), Quaternion.FromArray(rotation), Vector3.FromArray(position));
    return Matrix.Scaling(1, 1, this.z).multiply(pose.invert());
  }
  meshOf(object, pose) {
    const to_stage = this.toStageOf(pose);
    const parts = this.meshesOf(object).flatMap((mesh) => {
      const positions = mesh.getPositionData(true, true);
      const corners = mesh.getIndices();
      const to = mesh.computeWorldMatrix(true).multiply(to_stage);
      const copies = mesh.thinInstanceCount
        ? mesh.thinInstanceGetWorldMatrices().slice(0, mesh.thinInstanceCount)
        : null;
      return (copies?.map((copy) => copy.multiply(to)) ?? [to]).map(({ m: matrix }) => ({
        positions,
        corners,
        matrix,
      }));
    });
    return oneMesh(parts);
  }
  // What the mesh of an object depends on, but for its pose.
  shapeOf(object, pose) {
    const to_stage = this.toStageOf(pose);
    return this.meshesOf(object).flatMap((mesh) => [
      ...mesh.computeWorldMatrix(true).multiply(to_stage).m,
      ...(mesh.skeleton?.getTransformMatrices(mesh) ?? []),
      ...(mesh.morphTargetManager?.influences ?? []),
      mesh.thinInstanceCount ?? 0,
    ]);
  }
  // Column-major matrices of a camera that looks along -z of the stage's world.
  matricesOf(camera) {
    const view = [...camera.getViewMatrix().m];
    const projection = [...camera.getProjectionMatrix().m];
    if (this.z < 0) for (let i = 0; i < 16; ++i) if ((i % 4 === 2) !== (i >> 2 === 2)) view[i] = -view[i];
    if (this.z < 0) for (let i = 8; i < 12; ++i) projection[i] = -projection[i];
    return { view, projection };
  }
  cameraOf(camera) {
    const { Matrix, Quaternion } = this.BABYLON;
    const { view, projection } = this.matricesOf(camera);
    const orientation = Quaternion.FromRotationMatrix(Matrix.FromArray(view).invert().getRotationMatrix()).asArray();
    return { position: this.mirrored(camera.globalPosition.asArray()), orientation, ...frustumOf(projection) };
  }

  // The material of a surface that shadows fall on. It stays as it is otherwise. With `shadowOnly` it is seen through but for
  // its shadows, as a real floor in the camera's picture.
  receive(material, options = {}) {
    checked("receive", options, { shadowOnly: 0 });
    const { shadowOnly = false } = options;
    this.receiver.receive(material, shadowOnly);
    if (shadowOnly) material.transparencyMode = 2; // MATERIAL_ALPHABLEND
    return material;
  }
  // No shadow of this stage falls on it any more.
  stopReceiving(material) {
    this.receiver.stop(material);
  }

  hide(object) {
    const enabled = object.isEnabled(false);
    object.setEnabled(false);
    return () => object.setEnabled(enabled);
  }
  // Hides what is behind it: its depth is drawn before all else, and a little farther, and then its shadows on what is there. Opaque
  // meshes are drawn in the order of their materials' numbers.
  veilOf(object, { positions, indices }, pose) {
    const { BABYLON, scene, z } = this;
    const data = new BABYLON.VertexData();
    data.positions = positions.map((x, i) => (i % 3 === 2 ? z * x : x));
    data.indices = z < 0 ? indices.map((_, i) => indices[i - (i % 3) + [0, 2, 1][i % 3]]) : indices;
    const { backFaceCulling = true } = object.found
      ? { backFaceCulling: false }
      : (this.meshesOf(object)[0].material ?? {});
    const depth = new BABYLON.StandardMaterial("sandglass", scene);
    const shaded = new BABYLON.PBRMaterial("sandglass", scene);
    Object.assign(depth, { disableColorWrite: true, zOffset: 1, zOffsetUnits: 1, uniqueId: -scene.getUniqueId() });
    Object.assign(shaded, { metallic: 0, roughness: 1, disableDepthWrite: true });
    const root = new BABYLON.TransformNode("sandglass", scene);
    for (const material of [depth, this.receive(shaded, { shadowOnly: true })]) {
      const mesh = new BABYLON.Mesh("sandglass", scene, root);
      data.applyToMesh(mesh);
      material.backFaceCulling = backFaceCulling;
      Object.assign(mesh, { material, alphaIndex: -1e9, isPickable: false });
    }
    const veil = {
      move({ position, rotation: [x, y, ...zw] }) {
        root.position.set(position[0], position[1], z * position[2]);
        root.rotationQuaternion = new BABYLON.Quaternion(z * x, z * y, ...zw);
      },
      end: () => {
        this.stopReceiving(shaded);
        root.dispose(false, true);
      },
    };
    veil.move(pose);
    return veil;
  }

  // Shadows fall on what is drawn already, by its depth.
  receiveByDepth(options) {
    this.refuseEnded();
    const made = new BabylonDepthReceiver(this, options);
    this.byDepth.add(made);
    return made;
  }

  // Sand, as a node of meshes in the scene. Options as for Stage.createSand.
  async createSand(options) {
    await this.newSand(options);
    return this.sand.root;
  }
  sandOf(block, radius) {
    return new BabylonSand(this.BABYLON, this.scene, this.z, block, radius);
  }

  leave() {
    if (this.scene.environmentTexture === this.around) this.scene.environmentTexture = null;
    this.around.dispose();
    this.sun.dispose();
    for (const one of this.byDepth) one.dispose();
    this.receiver.end();
  }
  show(drawn, changed) {
    const { BABYLON, around, sun } = this;
    const { toLight, facing, ambient } = drawn.light;
    // The engine's vectors have their z reversed, in scenes of both hands. The terms are those that it would make of harmonics.
    const harmonics = BABYLON.SphericalHarmonics.FromArray(
      Array.from({ length: 9 }, (_, k) => ambient.slice(3 * k, 3 * k + 3).map((x) => ([2, 5, 7].includes(k) ? -x : x))),
    );
    harmonics.preScaled = true;
    around.sphericalPolynomial = BABYLON.SphericalPolynomial.FromHarmonics(harmonics);
    sun.direction = BABYLON.Vector3.FromArray(this.mirrored(toLight)).negate();
    sun.diffuse = BABYLON.Color3.FromArray(facing);
    sun.specular = sun.diffuse;
    this.receiver.set(drawn, changed);
    for (const one of this.byDepth) one.showTextures();
  }
}
