// Shadows on what is drawn already, as far as its depth is known: a triangle over the whole picture that takes off it what they hide.
import { checked } from "./options.mjs";

const k_kinds = { depth: 0, metres: 1, camera: 0, fromView: 16, heights: 0 };
const k_nearly = 0.9999; // of the depth of what a depth buffer shows nothing at
const k_farthest = 1e6; // metres, of a texture that has them
const k_identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export class DepthReceiver {
  // `stage`: of three.mjs.
  constructor(stage, options) {
    const { THREE } = stage;
    this.stage = stage;
    this.values = {
      sandglass_known: new THREE.Vector4(),
      sandglass_metres: new THREE.Vector4(),
      ...Object.fromEntries(["to_depth", "from_depth", "to_heights"].map((x) => [`sandglass_${x}`, new THREE.Matrix4()])),
    };
    this.nothing = dataTexture(THREE, new Uint16Array(1), 1, 1);
    this.options = { fromView: k_identity };
    // What overrides its material draws nothing.
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(9), 3));
    this.mesh = new THREE.Mesh(geometry, null);
    this.set(options);
    Object.assign(this.mesh, {
      frustumCulled: false,
      renderOrder: -1,
      raycast() {},
      onBeforeRender: (renderer, _scene, camera) => this.#see(renderer, camera),
    });
    stage.scene.add(this.mesh);
  }
  // What is not given stays as it was.
  set(options = {}) {
    const given = checked("receiveByDepth", options, k_kinds);
    const { options: before, values } = this;
    const next = { ...before, ...given };
    refuseDepth(next);
    this.options = next;
    if ("heights" in given) this.#takeHeights(next.heights);
    values.sandglass_depth = next.depth ?? this.nothing;
    values.sandglass_heights = this.heights ?? this.nothing;
    const isOther = next.depth?.isDepthTexture !== before.depth?.isDepthTexture; // nodes read it in another way
    if (!this.mesh.material || isOther) this.#newMaterial();
  }
  #newMaterial() {
    const { THREE, receiver } = this.stage;
    this.#endMaterial();
    this.mesh.material = receiver.byDepth(this.values, {
      // Black as far as light is missing, in whatever order: it lies behind all that is drawn.
      blending: THREE.CustomBlending,
      blendSrc: THREE.ZeroFactor,
      blendDst: THREE.OneMinusSrcAlphaFactor,
      blendSrcAlpha: THREE.OneFactor,
      depthWrite: false,
      fog: false,
      toneMapped: false,
      transparent: this.mesh.material?.transparent ?? false,
    });
  }
  #endMaterial() {
    const { material } = this.mesh;
    if (!material) return;
    this.stage.receiver.stop(material);
    material.dispose();
  }
  #takeHeights(heights) {
    const { THREE } = this.stage;
    this.heights?.dispose();
    this.heights = null;
    this.values.sandglass_known.z = 0;
    if (!heights) return;
    const numbers = Uint16Array.from(heights.heights, THREE.DataUtils.toHalfFloat);
    this.heights = dataTexture(THREE, numbers, ...heights.cells);
    this.values.sandglass_known.z = heights.heights.reduce((most, x) => Math.max(most, x), 0);
    const [corner, along, across, up] = ["corner", "along", "across", "up"].map((x) => new THREE.Vector3(...heights[x]));
    along.divideScalar(along.lengthSq());
    across.divideScalar(across.lengthSq());
    this.values.sandglass_to_heights.set(
      ...[along, up, across].flatMap((row) => [...row.toArray(), -row.dot(corner)]),
      ...[0, 0, 0, 1],
    );
  }
  // How this camera sees, and the depth's own.
  #see(renderer, view) {
    const { stage, values, options } = this;
    const { THREE, drawn } = stage;
    const { depth, metres, fromView } = options;
    const camera = options.camera ?? view;
    const known = values.sandglass_known;
    known.y = options.camera ? 1 : 0;
    known.x = depth ? k_farthest : 0;
    if (depth?.isDepthTexture) known.x = k_nearly * bufferDepth(THREE, camera, values.sandglass_metres);
    else values.sandglass_metres.set(metres ?? 1, 0, 0, 1);
    const to = values.sandglass_to_depth.fromArray(fromView);
    // Its lower row is the first.
    if (renderer.isWebGLRenderer && (depth?.isDepthTexture || depth?.isRenderTargetTexture))
      to.premultiply(new THREE.Matrix4().set(1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1));
    if (options.camera) {
      camera.updateWorldMatrix(true, false);
      camera.matrixWorldInverse.copy(camera.matrixWorld).invert();
      to.multiply(toPicture(THREE, camera));
      values.sandglass_from_depth.copy(to).invert();
    }
    if (!this.heights) values.sandglass_to_heights.set(0, 0, 0, -1, 0, 1, 0, -(drawn?.floor ?? 0), 0, 0, 0, -1, 0, 0, 0, 1);
    stage.receiver.showDepth(this.mesh.material, values);
  }
  dispose() {
    const { mesh, stage } = this;
    stage.byDepth.delete(this);
    mesh.removeFromParent();
    this.#endMaterial();
    for (const one of [mesh.geometry, this.nothing, this.heights]) one?.dispose();
  }
}

function refuseDepth({ depth, metres, heights }) {
  if (depth && !depth.isTexture)
    throw new Error("sandglass: receiveByDepth takes a texture as depth. Of a render target pass its depthTexture.");
  if (depth && !depth.isDepthTexture && !metres)
    throw new Error(
      "sandglass: receiveByDepth needs what the numbers of a depth image are times to give metres. Pass { metres }.",
    );
  if (!heights) return;
  const [columns, rows] = heights.cells ?? [];
  const given = heights.heights?.length ?? "no";
  if (!(given === columns * rows))
    throw new Error(`sandglass: receiveByDepth needs a height for each of ${columns} x ${rows} cells, not ${given}.`);
  if (!["corner", "along", "across", "up"].every((name) => heights[name]?.length === 3))
    throw new Error("sandglass: receiveByDepth needs corner, along, across and up of heights, as sandglass_heights has them.");
}

const dataTexture = ({ DataTexture, RedFormat, HalfFloatType, LinearFilter }, numbers, columns, rows) =>
  Object.assign(new DataTexture(numbers, columns, rows, RedFormat, HalfFloatType), {
    minFilter: LinearFilter,
    magFilter: LinearFilter,
    unpackAlignment: 2,
    needsUpdate: true,
  });

// How a camera's depth buffer gives metres along its axis, and those at which nothing is drawn.
function bufferDepth({ WebGPUCoordinateSystem }, { projectionMatrix, coordinateSystem, reversedDepth }, metres) {
  const [from, to] = [projectionMatrix.elements[10], projectionMatrix.elements[14]];
  const fromZero = coordinateSystem === WebGPUCoordinateSystem || reversedDepth === true;
  metres.set(0, to, fromZero ? 1 : 2, fromZero ? from : from - 1);
  return to / ((reversedDepth === true ? 0 : 1) + from);
}

// From the world to x and y of a camera's picture, from its upper left corner, times the depth; to 1; to the depth.
function toPicture({ Matrix4 }, { projectionMatrix, matrixWorldInverse }) {
  const to = new Matrix4().set(0.5, 0, 0, 0.5, 0, -0.5, 0, 0.5, 0, 0, 0, 0, 0, 0, 0, 1);
  to.multiply(projectionMatrix).multiply(matrixWorldInverse);
  [0, 0, 0, 1].forEach((x, column) => (to.elements[4 * column + 2] = x));
  return to;
}
