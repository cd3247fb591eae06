// What shadows leave of a material's light under WebGPURenderer, by nodes: of the light from all around by the material's aoNode, of
// the main light where it shines on a material that receives.
import { depthNumbers, kitValues, receiverValues } from "./glsl.mjs";
import { depthNodes, receiveNodes, surfaceNodes } from "./kit_nodes.mjs";
import { Given } from "./three_nodes.mjs";
import { ShadowTextures, nothingDrawn } from "./shadow_textures.mjs";
import { textureMaker } from "./three_sand.mjs";

const k_lit = /^Mesh(Standard|Physical|Lambert|Phong)(Node)?Material$/;
const k_of_node = ["aoNode", "outputNode", "customProgramCacheKey"];

const owners = new WeakMap(); // which receiver each material shows
let made = 0;

export class NodeReceiver {
  // `sun`: the main light; `onScreen`: whether the picture is blended with what lies behind the canvas.
  constructor(THREE, renderer, sun, onScreen) {
    const { TSL: T } = THREE;
    Object.assign(this, { THREE, renderer, onScreen, materials: new Map(), number: ++made });
    this.given = new Given(THREE);
    this.textures = new ShadowTextures(textureMaker(THREE), (name, texture) =>
      this.given.set({ [`sandglass_${name}`]: texture }),
    );
    this.given.set({ blended: 0 });
    this.set(nothingDrawn, []);
    this.left = T.Fn(() => receiveNodes(T, this.given.nodes).sandglass_left(T.positionWorld).toVar())();
    this.rest = this.left.y;
    const colour = T.uniform(sun.color);
    sun.colorNode = T.Fn((builder) => (this.#has(builder.material) ? colour.mul(this.left.x) : colour))();
  }
  #has(material) {
    return [...this.materials.values()].some(({ aoNode }) => aoNode === material.aoNode);
  }
  receive(material, shadowOnly) {
    if (!k_lit.test(material?.type))
      throw new Error(
        `sandglass: no shadow falls on a ${material?.type ?? "thing without a type"}. receive takes the material of a mesh, which three lights: a MeshStandardMaterial.`,
      );
    owners.get(material)?.stop(material);
    owners.set(material, this);
    const { TSL: T } = this.THREE;
    const before = k_of_node.map((name) => [name, Object.hasOwn(material, name), material[name]]);
    const own = material.aoNode ?? (material.aoMap ? T.materialAO : T.float(1));
    const aoNode = own.mul(this.rest);
    this.materials.set(material, { aoNode, before });
    const key = material.customProgramCacheKey();
    Object.assign(material, {
      aoNode,
      customProgramCacheKey: () => `${key} sandglass ${this.number} ${shadowOnly}`,
      ...(shadowOnly ? { outputNode: this.#shadowOnly() } : {}),
    });
    material.needsUpdate = true;
  }
  // It is as it was.
  stop(material) {
    if (!this.materials.has(material)) return;
    for (const [name, had, value] of this.materials.get(material).before)
      if (had) material[name] = value;
      else delete material[name];
    this.materials.delete(material);
    owners.delete(material);
    material.needsUpdate = true;
  }
  // A material that is drawn over the whole picture, by what a depth texture tells.
  byDepth(values, options) {
    const { THREE, renderer } = this;
    const { TSL: T } = THREE;
    const own = new Given(THREE);
    const material = Object.assign(new THREE.MeshBasicNodeMaterial(options), { sandglass: own });
    const corner = [1, 2].map((vertex) => T.select(T.vertexIndex.equal(vertex), 3, -1).toFloat());
    const at = T.varying(T.vec2(corner[0].mul(0.5).add(0.5), corner[1].mul(-0.5).add(0.5)));
    const [right, up, back] = [0, 1, 2].map((k) => T.cameraProjectionMatrix.element(k));
    const way = T.vec4(corner[0].add(back.x).div(right.x), corner[1].add(back.y).div(up.y), -1, 0);
    const ray = T.varying(T.cameraWorldMatrix.mul(way).xyz);
    material.vertexNode = T.vec4(...corner, renderer.reversedDepthBuffer ? 0 : 1, 1);
    if (renderer.logarithmicDepthBuffer) material.depthNode = T.float(1);
    this.showDepth(material, values);
    material.outputNode = T.Fn(() => {
      const { sandglass_depth } = own.nodes;
      // r184 cannot name a level of a depth texture by WebGL.
      const plain = { sample: (at) => ({ level: () => sandglass_depth.sample(at) }) };
      const depth = { sandglass_depth: sandglass_depth.value.isDepthTexture ? plain : sandglass_depth };
      const { sandglass_left_by_depth } = depthNodes(T, { ...this.given.nodes, ...own.nodes, ...depth });
      return this.#black(sandglass_left_by_depth(at, T.cameraPosition, ray).toVar());
    })();
    return material;
  }
  showDepth(material, values) {
    material.sandglass.set(values);
  }
  // As far as light is missing. What is blended on the screen has the screen's numbers.
  #black(share) {
    const { TSL: T } = this.THREE;
    const encoded = T.sRGBTransferOETF(T.vec3(share)).x;
    return T.vec4(0, 0, 0, T.sub(1, T.select(this.given.nodes.blended.greaterThan(0.5), encoded, share)));
  }
  // Of a white surface.
  #shadowOnly() {
    const { TSL: T } = this.THREE;
    const given = this.given.nodes;
    return T.Fn(() => {
      const { around } = surfaceNodes(T, given);
      const sun = T.vec3(given.sun.mul(T.normalWorld.dot(given.to_light).max(0))).toVar();
      const room = T.vec3(around(T.normalWorld)).toVar();
      const all = T.dot(sun.add(room), T.vec3(1));
      const share = T.dot(sun.mul(this.left.x).add(room.mul(this.left.y)), T.vec3(1))
        .div(all.max(1e-6))
        .toVar();
      return this.#black(share);
    })();
  }
  // `changed`: names of textures.
  set(drawn, changed) {
    const values = { ...receiverValues(drawn), ...kitValues(drawn), sandglass_depth_numbers: depthNumbers(drawn) };
    this.given.set({ ...values, blended: this.onScreen() ? 1 : 0 });
    for (const name of changed) this.textures.show(name, drawn.textures[name]);
  }
  end() {
    for (const material of [...this.materials.keys()]) this.stop(material);
    this.textures.end();
  }
}
