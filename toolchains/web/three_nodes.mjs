// How sand looks by nodes: for WebGPURenderer, on WebGPU and on WebGL.
import { k_block_side } from "./loose_sand.mjs";
import { looseNodes, surfaceNodes } from "./kit_nodes.mjs";
import { k_packed_sides, packedBlock } from "./packed_block.mjs";
import { blockTexture } from "./three_sand.mjs";

const k_lengths = { ambient: [9, 3], minerals: [4, 4], streams: [3, 4], stream_ways: [3, 4] };
const k_vectors = { 3: "Vector3", 4: "Vector4", 9: "Matrix3", 16: "Matrix4" };

// Nodes of uniforms by name, made when they are first given a value: numbers, vectors, rows of vectors and textures.
export class Given {
  constructor(THREE) {
    this.THREE = THREE;
    this.nodes = {};
  }
  set(values) {
    for (const [name, value] of Object.entries(values)) {
      if (value?.isTexture) this.#texture(name, value);
      else if (name in k_lengths) this.#rows(name, value.flat());
      else if (typeof value === "number") (this.nodes[name] ??= this.THREE.TSL.uniform(value)).value = value;
      else this.#vector(name, value);
    }
  }
  #texture(name, value) {
    const { TSL } = this.THREE;
    this.nodes[name] ??= value.isData3DTexture ? TSL.texture3D(value) : TSL.texture(value);
    this.nodes[name].value = value;
  }
  #rows(name, values) {
    const { THREE } = this;
    const [count, size] = k_lengths[name];
    this.nodes[name] ??= THREE.TSL.uniformArray(Array.from({ length: count }, () => new THREE[k_vectors[size]]()));
    this.nodes[name].array.forEach((row, i) => row.fromArray(values, size * i));
  }
  #vector(name, values) {
    const { THREE } = this;
    this.nodes[name] ??= THREE.TSL.uniform(new THREE[k_vectors[values.length]]());
    this.nodes[name].value.fromArray(values);
  }
}

export class NodeLook {
  // `block`: of sandBlock.
  constructor(THREE, block, renderer) {
    const { grains, facets } = packedBlock(block);
    this.THREE = THREE;
    this.first = renderer.backend.isWebGPUBackend === true;
    this.given = new Given(THREE);
    this.given.set({
      grains: blockTexture(THREE, grains, k_packed_sides),
      facets: blockTexture(THREE, facets, k_packed_sides),
      block_side: k_block_side,
      wet: 0,
    });
  }
  // The materials are made with the first values.
  set(values) {
    this.given.set(values);
  }
  get surface() {
    return (this.made ??= this.#make()).surface;
  }
  get loose() {
    return (this.made ??= this.#make()).loose;
  }
  #make() {
    const nodes = { ...this.given.nodes, ...this.#camera() };
    return { surface: this.#surface(nodes), loose: [0, 1].map((flies) => this.#loose(nodes, flies)) };
  }
  // Sand is lit where it is simulated, wherever its group stands.
  #camera() {
    const { TSL: T } = this.THREE;
    // The pixels of a viewport of an eye, which are the canvas' if they are no target's.
    const ratio = T.uniform(1).onRenderUpdate(({ renderer }) => {
      const target = renderer.getRenderTarget();
      return target && !target.isPostProcessingRenderTarget ? 1 : renderer.getPixelRatio();
    });
    const height = T.Fn(({ camera }) =>
      camera.isArrayCamera && camera.cameras.length > 0 ? T.cameraViewport.w.mul(ratio) : T.viewportSize.y,
    );
    return {
      view: T.modelViewMatrix,
      projection: T.cameraProjectionMatrix,
      eye: T.modelWorldMatrixInverse.mul(T.vec4(T.cameraPosition, 1)).xyz,
      pixels: height().mul(0.5).mul(T.cameraProjectionMatrix.element(1).element(1)),
    };
  }
  #surface(given) {
    const { THREE } = this;
    const { TSL: T } = THREE;
    const normal = T.varying(T.attribute("sand_normal", "vec4"));
    const origin = T.attribute("sand_origin", "vec4");
    const height = T.varying(origin.w.mul(65535).sub(32768).mul(1e-6));
    const begins = T.varying(origin.xyz.mul(65535 / 65536)).setInterpolation("flat");
    const material = new THREE.MeshBasicNodeMaterial({ side: THREE.DoubleSide });
    material.colorNode = T.Fn(() => {
      const { sand_surface } = surfaceNodes(T, given);
      return T.vec4(sand_surface(T.positionGeometry, normal.xyz, normal.w, height, begins), 1);
    })();
    return material;
  }
  #loose(nodes, flies) {
    const { THREE } = this;
    const { TSL: T } = THREE;
    const given = { ...nodes, flies: T.float(flies) };
    const names = { at: "vec2", across: "float", stands: "vec3", up: "vec3", own: "float", seed: "uint" };
    const handed = Object.entries(names).map(([name, type]) => [name, T.varyingProperty(type, `loose_${name}`)]);
    const material = new THREE.MeshBasicNodeMaterial({ side: THREE.DoubleSide });
    material.vertexNode = T.Fn(() => {
      const { loose_grain, globals } = looseNodes(T, given);
      const number = T.uint(T.attribute("sand_number", "float"));
      loose_grain(T.uint(T.vertexIndex), T.attribute("sand_place", "vec4"), T.attribute("sand_way", "vec3"), number);
      for (const [name, varying] of handed) varying.assign(globals[`grain_${name}`]);
      return globals.grain_position;
    })();
    material.colorNode = T.Fn(() => {
      const { grain_lit, grain_shown } = looseNodes(T, given);
      const [at, across, ...rest] = handed.map(([, varying]) => varying);
      T.Discard(grain_lit(at, across).lessThanEqual(0));
      return T.vec4(grain_shown(at, across, ...rest), 1);
    })();
    return material;
  }
  // Of a metre at a distance of one, in what is drawn now.
  pixels(renderer, camera) {
    const target = renderer.getRenderTarget();
    const height = target?.height ?? renderer.getDrawingBufferSize(new this.THREE.Vector2()).y;
    return 0.5 * height * camera.projectionMatrix.elements[5];
  }
  end() {
    const { surface, loose } = this.made ?? { loose: [] };
    for (const material of [surface, ...loose]) material?.dispose();
    for (const name of ["grains", "facets"]) this.given.nodes[name].value.dispose();
  }
}
