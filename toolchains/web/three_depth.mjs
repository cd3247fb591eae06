// Shadows on what is drawn already, as far as its depth is known: a triangle over the whole picture that takes off it what they hide.
import { DepthView } from "./depth_view.mjs";

export class DepthReceiver {
  // `stage`: of three.mjs.
  constructor(stage, options = {}) {
    const { THREE } = stage;
    const view = new DepthView(
      ({ isTexture }) => isTexture,
      ({ isDepthTexture }) => isDepthTexture,
    );
    Object.assign(this, { stage, view, values: view.values({}, null, false, 0), heights: null });
    this.nothing = dataTexture(THREE, new Uint16Array(1), 1, 1);
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
  set(options) {
    const { THREE } = this.stage;
    const { view, values, nothing, mesh } = this;
    const { depth: before } = view.options;
    if ("heights" in view.set(options)) {
      const { heights } = view.options;
      this.heights?.dispose();
      this.heights = null;
      if (heights) {
        const numbers = Uint16Array.from(heights.heights, THREE.DataUtils.toHalfFloat);
        this.heights = dataTexture(THREE, numbers, ...heights.cells);
      }
    }
    const { depth } = view.options;
    Object.assign(values, { sandglass_depth: depth ?? nothing, sandglass_heights: this.heights ?? nothing });
    if (!mesh.material || depth?.isDepthTexture !== before?.isDepthTexture) this.#newMaterial(); // nodes read it in another way
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
  #see(renderer, camera) {
    const { stage, view, values, mesh } = this;
    const { THREE, drawn } = stage;
    const { depth, camera: own } = view.options;
    own?.updateWorldMatrix(true, false);
    own?.matrixWorldInverse.copy(own.matrixWorld).invert();
    const seen = (one) => ({
      view: one.matrixWorldInverse.elements,
      projection: one.projectionMatrix.elements,
      fromZero: one.coordinateSystem === THREE.WebGPUCoordinateSystem || one.reversedDepth === true,
      reversed: one.reversedDepth === true,
    });
    // Nodes turn a target's texture themselves.
    const flip = renderer.isWebGLRenderer && (depth?.isDepthTexture || depth?.isRenderTargetTexture);
    const inverse = (matrix) => new THREE.Matrix4().fromArray(matrix).invert().elements;
    Object.assign(values, view.values(seen(camera), own ? seen(own) : null, flip, drawn?.floor ?? 0, inverse));
    stage.receiver.showDepth(mesh.material, values);
  }
  dispose() {
    const { mesh, stage } = this;
    stage.byDepth.delete(this);
    mesh.removeFromParent();
    this.#endMaterial();
    for (const one of [mesh.geometry, this.nothing, this.heights]) one?.dispose();
  }
}

const dataTexture = ({ DataTexture, RedFormat, HalfFloatType, LinearFilter }, numbers, columns, rows) =>
  Object.assign(new DataTexture(numbers, columns, rows, RedFormat, HalfFloatType), {
    minFilter: LinearFilter,
    magFilter: LinearFilter,
    unpackAlignment: 2,
    needsUpdate: true,
  });
