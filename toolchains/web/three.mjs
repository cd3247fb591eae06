// sandglass/three: a stage in a scene of three.js, which the app hands over; nothing is imported of it.
import { Engine, oneMesh } from "./engine.mjs";
import { DepthReceiver } from "./three_depth.mjs";
import { NodeReceiver } from "./three_node_receive.mjs";
import { GlslReceiver } from "./three_receive.mjs";
import { GlslLook } from "./three_glsl.mjs";
import { NodeLook } from "./three_nodes.mjs";
import { ThreeSand } from "./three_sand.mjs";
import { checked } from "./options.mjs";
import { frustumOf } from "./place_light.mjs";

// The lowest that have what is used: chunks and ranges of buffers; one node material for both of its back ends.
const k_first = -1000; // in the order of drawing, of what hides and is not seen
const k_revisions = { webgl: 160, nodes: 184 };

// `renderer` and `scene` are needed; `worker`: the stage runs in a Worker; else options of Stage.create.
export async function createStage(THREE, { renderer, scene, ...options } = {}) {
  if (!renderer?.isWebGLRenderer && !renderer?.isWebGPURenderer)
    throw new Error(
      "sandglass: createStage needs the renderer of three. Call createStage(THREE, { renderer: new THREE.WebGLRenderer(), scene }).",
    );
  const least = renderer.isWebGPURenderer ? k_revisions.nodes : k_revisions.webgl;
  if (!(Number.parseInt(THREE.REVISION) >= least))
    throw new Error(
      `sandglass: createStage needs three r${least} or newer for this renderer, and this is r${THREE.REVISION}. Update three.`,
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
      byDepth: new Set(),
      placing: "updateWorldMatrix",
    });
    scene.add(this.probe, this.sun, this.sun.target);
    this.receiver = renderer.isWebGPURenderer
      ? new NodeReceiver(THREE, renderer, this.sun, () => scene.background === null && renderer.getClearAlpha() < 1)
      : new GlslReceiver(THREE);
    this.renew = () => this.sand?.renew();
    renderer.domElement?.addEventListener?.("webglcontextrestored", this.renew);
  }

  poseOf(object) {
    const { Vector3, Quaternion } = this.THREE;
    const position = new Vector3();
    const rotation = new Quaternion();
    object.updateWorldMatrix(true, false);
    object.matrixWorld.decompose(position, rotation, new Vector3());
    rotation.normalize(); // of what is sheared it has another length
    return { position: position.toArray(), rotation: rotation.toArray() };
  }
  isShown(object) {
    let one = object;
    while (one?.visible && one !== this.scene) one = one.parent;
    return one?.visible === true;
  }
  // The meshes of an object that are seen where it is: no hidden child, of a LOD its present level, and none whose places
  // a shader makes, as of thick lines.
  meshesOf(object) {
    const meshes = [];
    const visit = (one) => {
      const { isMesh, geometry, isLOD, children } = one;
      if (isMesh && geometry?.getAttribute("position") && !geometry.isInstancedBufferGeometry) meshes.push(one);
      const level = isLOD && one.levels[one.getCurrentLevel()]?.object;
      for (const child of children) if (level ? child === level : child.visible) visit(child);
    };
    object.updateWorldMatrix(true, true);
    visit(object);
    return meshes;
  }
  toStageOf({ position, rotation }) {
    const { Vector3, Quaternion, Matrix4 } = this.THREE;
    return new Matrix4().compose(new Vector3(...position), new Quaternion(...rotation), new Vector3(1, 1, 1)).invert();
  }
  meshOf(object, pose) {
    const from = this.toStageOf(pose);
    const parts = this.meshesOf(object).flatMap((mesh) => {
      const to = from.clone().multiply(mesh.matrixWorld);
      return this.copiesOf(mesh).map(({ matrix, start, count }) => ({
        ...this.trianglesOf(mesh, start, count),
        matrix: (matrix ? to.clone().multiply(matrix) : to).elements,
      }));
    });
    return oneMesh(parts);
  }
  // How often a mesh is drawn: each time by a matrix of its own, and a range of its triangles.
  copiesOf(mesh) {
    const { Matrix4 } = this.THREE;
    const { start, count } = mesh.geometry.drawRange;
    if (mesh.isInstancedMesh)
      return Array.from({ length: mesh.count }, (_, i) => {
        const matrix = new Matrix4();
        mesh.getMatrixAt(i, matrix);
        return { matrix, start, count };
      });
    if (!mesh.isBatchedMesh) return [{ start, count }];
    const copies = [];
    for (let i = 0, left = mesh.instanceCount; left > 0 && i < mesh.maxInstanceCount; ++i) {
      try {
        const seen = mesh.getVisibleAt(i);
        --left;
        if (seen)
          copies.push({
            matrix: mesh.getMatrixAt(i, new Matrix4()),
            ...mesh.getGeometryRangeAt(mesh.getGeometryIdAt(i)),
          });
      } catch {
        // an instance that was deleted
      }
    }
    return copies;
  }
  // A range of a mesh's triangles, bent as it is drawn: by its bones and morph targets.
  trianglesOf(mesh, start, count) {
    const {
      index,
      attributes: { position },
    } = mesh.geometry;
    const all = index ? index.count : position.count;
    const end = Math.min(all, start + count);
    const bent = mesh.isSkinnedMesh || mesh.morphTargetInfluences;
    const v = new this.THREE.Vector3();
    const placesOf = (length, vertexAt) => {
      const places = new Float32Array(3 * length);
      for (let i = 0; i < length; ++i) mesh.getVertexPosition(vertexAt(i), v).toArray(places, 3 * i);
      return places;
    };
    if (start > 0 || end < all)
      return {
        positions: placesOf(3 * Math.max(0, Math.floor((end - start) / 3)), (i) => index?.getX(start + i) ?? start + i),
      };
    const plain = !bent && position.isBufferAttribute && position.array instanceof Float32Array;
    return { positions: plain ? position.array : placesOf(position.count, (i) => i), corners: index?.array };
  }
  // What the mesh of an object depends on, but for its pose.
  shapeOf(object, pose) {
    const from = this.toStageOf(pose);
    const to = new this.THREE.Matrix4();
    return this.meshesOf(object).flatMap((mesh) => [
      ...[mesh, ...(mesh.skeleton?.bones ?? [])].flatMap((one) => to.multiplyMatrices(from, one.matrixWorld).toArray()),
      ...(mesh.morphTargetInfluences ?? []),
      mesh.count ?? 1,
      mesh.instanceMatrix?.version ?? 0,
    ]);
  }
  cameraOf(camera) {
    const { position, rotation } = this.poseOf(camera);
    return { position, orientation: rotation, ...frustumOf(camera.projectionMatrix?.elements) };
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

  hide(object) {
    const { visible } = object;
    object.visible = false;
    return () => Object.assign(object, { visible });
  }
  // Hides what is behind it: its depth is drawn before all else, and a little farther, and then its shadows on what is there.
  veilOf(object, { positions, indices }, pose) {
    const { THREE } = this;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    const [first] = object.found ? [] : this.meshesOf(object);
    const { side = first ? THREE.FrontSide : THREE.DoubleSide } = [first?.material].flat()[0] ?? {};
    const shaded = new THREE.MeshStandardMaterial({ side, flatShading: true, fog: false, depthWrite: false });
    const materials = [
      new THREE.MeshBasicMaterial({
        ...{ side, colorWrite: false },
        ...{ polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 },
      }),
      this.receive(shaded, { shadowOnly: true }),
    ];
    const group = new THREE.Group();
    for (const material of materials)
      group.add(Object.assign(new THREE.Mesh(geometry, material), { renderOrder: k_first, raycast() {} }));
    const veil = {
      move({ position, rotation }) {
        group.position.set(...position);
        group.quaternion.set(...rotation);
      },
      end: () => {
        group.removeFromParent();
        this.stopReceiving(shaded);
        for (const one of [geometry, ...materials]) one.dispose();
      },
    };
    veil.move(pose);
    this.scene.add(group);
    return veil;
  }

  // Shadows fall on what is drawn already, by its depth.
  receiveByDepth(options) {
    this.refuseEnded();
    const made = new DepthReceiver(this, options);
    this.byDepth.add(made);
    return made;
  }

  // Sand, as a Group in the scene. Options as for Stage.createSand.
  async createSand(options) {
    await this.newSand(options);
    this.group = this.sand.group;
    this.scene.add(this.group);
    return this.group;
  }
  sandOf(block, radius) {
    const { THREE, renderer } = this;
    const look = renderer.isWebGPURenderer ? new NodeLook(THREE, block, renderer) : new GlslLook(THREE, block);
    return new ThreeSand(THREE, look, radius);
  }

  leave() {
    this.renderer.domElement?.removeEventListener?.("webglcontextrestored", this.renew);
    for (const one of [this.probe, this.sun, this.sun.target]) one.removeFromParent();
    for (const one of this.byDepth) one.dispose();
    this.receiver.end(); // materials get no shadows any more
  }
  show(drawn, changed) {
    const { toLight, facing, radiance } = drawn.light;
    this.probe.sh.fromArray(radiance);
    this.sun.color.setRGB(...facing);
    this.sun.position.set(...toLight);
    this.receiver.set(drawn, changed);
  }
}
