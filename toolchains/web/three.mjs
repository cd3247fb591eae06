// sandglass/three: a stage in a scene of three.js, which the app hands over; nothing is imported of it.
import { Engine, oneMesh } from "./engine.mjs";
import { NodeReceiver } from "./three_node_receive.mjs";
import { GlslReceiver } from "./three_receive.mjs";
import { GlslLook } from "./three_glsl.mjs";
import { NodeLook } from "./three_nodes.mjs";
import { ThreeSand } from "./three_sand.mjs";
import { checked } from "./options.mjs";

// `renderer` and `scene` are needed; `worker`: the stage runs in a Worker; else options of Stage.create.
export async function createStage(THREE, { renderer, scene, ...options } = {}) {
  if (!renderer?.isWebGLRenderer && !renderer?.isWebGPURenderer)
    throw new Error(
      "sandglass: createStage needs the renderer of three. Call createStage(THREE, { renderer: new THREE.WebGLRenderer(), scene }).",
    );
  if (renderer.isWebGPURenderer) await renderer.init();
  if (!scene?.isScene) throw new Error("sandglass: createStage needs the scene that is lit. Pass { scene }.");
  return new ThreeStage(THREE, renderer, scene, await Engine.stageOf(options));
}

class ThreeStage extends Engine {
  constructor(THREE, renderer, scene, stage) {
    super(stage);
    Object.assign(this, {
      THREE,
      scene,
      renderer,
      probe: new THREE.LightProbe(),
      sun: new THREE.DirectionalLight(),
      placing: "updateWorldMatrix",
    });
    scene.add(this.probe, this.sun, this.sun.target);
    this.receiver = renderer.isWebGPURenderer
      ? new NodeReceiver(THREE, this.sun, () => scene.background === null)
      : new GlslReceiver(THREE);
  }

  rigid(object) {
    const { Vector3, Quaternion } = this.THREE;
    const position = new Vector3();
    const rotation = new Quaternion();
    object.updateWorldMatrix(true, false);
    object.matrixWorld.decompose(position, rotation, new Vector3());
    return { position, rotation };
  }
  poseOf(object) {
    const { position, rotation } = this.rigid(object);
    return { position: position.toArray(), rotation: rotation.toArray() };
  }
  meshOf(object) {
    const { Vector3, Matrix4 } = this.THREE;
    const { position, rotation } = this.rigid(object);
    const from = new Matrix4().compose(position, rotation, new Vector3(1, 1, 1)).invert();
    const parts = [];
    const v = new Vector3();
    object.updateMatrixWorld(true);
    object.traverse((mesh) => {
      if (!mesh.isMesh) return;
      const {
        index,
        attributes: { position },
      } = mesh.geometry;
      const as_it_is =
        position.array instanceof Float32Array &&
        position.isBufferAttribute &&
        !mesh.isSkinnedMesh &&
        !mesh.morphTargetInfluences;
      const positions = as_it_is ? position.array : new Float32Array(3 * position.count);
      if (!as_it_is) for (let i = 0; i < position.count; ++i) mesh.getVertexPosition(i, v).toArray(positions, 3 * i);
      parts.push({ positions, corners: index?.array, matrix: from.clone().multiply(mesh.matrixWorld).elements });
    });
    return oneMesh(parts);
  }
  cameraOf(camera) {
    if (!camera.isPerspectiveCamera)
      throw new Error(`sandglass: see needs a PerspectiveCamera, not this ${camera.type}.`);
    const { position, rotation } = this.poseOf(camera);
    const { fov = 50, aspect = 1 } = camera;
    return {
      position,
      orientation: rotation,
      diagonal: (360 / Math.PI) * Math.atan(Math.hypot(1, aspect) * Math.tan((fov * Math.PI) / 360)),
    };
  }

  // The material of a surface that shadows fall on. It stays as it is otherwise. With `shadowOnly` it is seen through but for
  // its shadows, as a real floor in the camera's picture: they leave of what is behind the share of the light that is left.
  receive(material, options = {}) {
    checked("receive", options, { shadowOnly: 0 });
    const { shadowOnly = false } = options;
    this.receiver.receive(material, shadowOnly);
    if (shadowOnly) material.transparent = true;
    return material;
  }
  // No shadow of this stage falls on it any more.
  stopReceiving(material) {
    this.receiver.stop(material);
  }

  // Sand, as a Group in the scene. Options as for Stage.createSand.
  async createSand(options) {
    const before = this.sand?.group;
    await this.newSand(options);
    before?.removeFromParent();
    this.scene.add(this.sand.group);
    return this.sand.group;
  }
  sandOf(block, radius) {
    const { THREE, renderer } = this;
    const look = renderer.isWebGPURenderer ? new NodeLook(THREE, block, renderer) : new GlslLook(THREE, block);
    return new ThreeSand(THREE, look, radius);
  }

  leave() {
    this.receiver.end();
    for (const one of [this.probe, this.sun, this.sun.target, this.sand?.group]) one?.removeFromParent();
  }
  show(drawn, changed) {
    const { toLight, facing, radiance } = drawn.light;
    this.probe.sh.fromArray(radiance);
    this.sun.color.setRGB(...facing);
    this.sun.position.set(...toLight);
    this.receiver.set(drawn, changed);
  }
}
