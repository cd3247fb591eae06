// Shadows on what is drawn already, in Babylon.js: a triangle over the whole picture, in GLSL and WGSL, that takes off it what they hide.
import { byDepth } from "./glsl.mjs";
import { k_wgsl } from "./kit_wgsl.mjs";
import { DepthView } from "./depth_view.mjs";
import { texturesOf } from "./babylon_receive.mjs";

// Of the triangle: how a ray of the stage's world begins at the picture's middle (w: its depth) and goes on along x and y; the eye, and
// the power by which the picture is encoded.
const k_own = ["sandglass_middle", "sandglass_along", "sandglass_upwards", "sandglass_eye"];
const k_glsl = {
  vertexSource: `precision highp float;
attribute vec3 position;
${k_own.map((name) => `uniform vec4 ${name};`).join("\n")}
varying vec2 sandglass_on;
varying vec3 sandglass_ray;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  sandglass_on = 0.5 + vec2(0.5, -0.5) * corner;
  sandglass_ray = sandglass_middle.xyz + corner.x * sandglass_along.xyz + corner.y * sandglass_upwards.xyz;
  gl_Position = vec4(corner, sandglass_middle.w, 1);
}`,
  fragmentSource: `precision highp float;
precision highp sampler2D;
uniform vec4 sandglass_eye;
varying vec2 sandglass_on;
varying vec3 sandglass_ray;
${byDepth}
void main() {
  float share = sandglass_left_by_depth(sandglass_on, sandglass_eye.xyz, sandglass_ray);
  gl_FragColor = vec4(0, 0, 0, 1.0 - pow(share, sandglass_eye.w));
}`,
};
const k_types = { vec4: "vec4f", mat4: "mat4x4f" };
const { uniforms: k_uniforms, textures: k_textures, text: k_text } = k_wgsl.depth;
const k_handed = "varying sandglass_on: vec2f;\nvarying sandglass_ray: vec3f;";
const k_wgsl_source = {
  vertexSource: `attribute position: vec3f;
${k_own.map((name) => `uniform ${name}: vec4f;`).join("\n")}
${k_handed}
@vertex
fn main(input: VertexInputs) -> FragmentInputs {
  let corner = select(vec2f(-1.0), vec2f(3.0), vec2u(vertexInputs.vertexIndex) == vec2u(1, 2));
  vertexOutputs.sandglass_on = 0.5 + vec2f(0.5, -0.5) * corner;
  vertexOutputs.sandglass_ray = uniforms.sandglass_middle.xyz + corner.x * uniforms.sandglass_along.xyz + corner.y * uniforms.sandglass_upwards.xyz;
  vertexOutputs.position = vec4f(corner, uniforms.sandglass_middle.w, 1.0);
}`,
  fragmentSource: `${[...k_uniforms, ["sandglass_eye", "vec4"]].map(([name, type]) => `uniform ${name}: ${k_types[type]};`).join("\n")}
${k_handed}
${texturesOf("depth")}
${k_text}
@fragment
fn main(input: FragmentInputs) -> FragmentOutputs {
  let share = sandglass_left_by_depth(fragmentInputs.sandglass_on, uniforms.sandglass_eye.xyz, fragmentInputs.sandglass_ray);
  fragmentOutputs.color = vec4f(0.0, 0.0, 0.0, 1.0 - pow(share, uniforms.sandglass_eye.w));
}`,
};

export class BabylonDepthReceiver {
  // `stage`: of babylon.mjs.
  constructor(stage, options = {}) {
    const { BABYLON, scene } = stage;
    const view = new DepthView((depth) => typeof depth.getInternalTexture === "function");
    view.set(options);
    const { isWebGPU } = scene.getEngine();
    Object.assign(this, {
      stage,
      view,
      heights: null,
      nothing: this.#texture(BABYLON, scene, new Uint16Array(1), [1, 1]),
    });
    const material = new BABYLON.ShaderMaterial("sandglass", scene, isWebGPU ? k_wgsl_source : k_glsl, {
      attributes: ["position"],
      uniforms: [...k_own, ...k_uniforms.map(([name]) => name)],
      samplers: k_textures.map(([name]) => name),
      needAlphaBlending: true,
      shaderLanguage: isWebGPU ? 1 : 0,
    });
    // It lies behind all that is drawn.
    Object.assign(material, { disableDepthWrite: true, backFaceCulling: false });
    const mesh = new BABYLON.Mesh("sandglass", scene);
    mesh.setVerticesData("position", new Float32Array(9)); // for other materials there is nothing to draw
    mesh.setIndices([0, 1, 2]);
    Object.assign(mesh, { material, alphaIndex: 0, alwaysSelectAsActiveMesh: true, isPickable: false });
    mesh.onBeforeRenderObservable.add(() => this.#see());
    this.mesh = mesh;
    this.set(options);
  }
  #texture({ RawTexture, Constants }, scene, numbers, [columns, rows]) {
    const { TEXTURE_BILINEAR_SAMPLINGMODE, TEXTURETYPE_HALF_FLOAT, TEXTURE_CLAMP_ADDRESSMODE } = Constants;
    const how = [scene, false, false, TEXTURE_BILINEAR_SAMPLINGMODE, TEXTURETYPE_HALF_FLOAT];
    const made = RawTexture.CreateRTexture(numbers, columns, rows, ...how);
    made.wrapU = made.wrapV = TEXTURE_CLAMP_ADDRESSMODE;
    made.anisotropicFilteringLevel = 1; // neighbours are metres apart
    return made;
  }
  // What is not given stays as it was.
  set(options) {
    const { BABYLON, scene } = this.stage;
    if ("heights" in this.view.set(options)) {
      const { heights } = this.view.options;
      this.heights?.dispose();
      const numbers = heights && Uint16Array.from(heights.heights, BABYLON.ToHalfFloat);
      this.heights = heights && this.#texture(BABYLON, scene, numbers, heights.cells);
    }
    this.showTextures();
  }
  // Whatever of them was made anew: with one that is gone, nothing is drawn.
  showTextures() {
    const { stage, view, mesh, heights, nothing } = this;
    const own = { sandglass_depth: view.options.depth ?? nothing, sandglass_heights: heights ?? nothing };
    for (const [name] of k_textures)
      mesh.material.setTexture(name, own[name] ?? stage.receiver.textures.all[name.replace("sandglass_", "")]);
  }
  #see() {
    const { stage, view, mesh } = this;
    const { BABYLON, scene, receiver, drawn } = stage;
    const { Matrix, Vector4 } = BABYLON;
    const { depth, camera } = view.options;
    const inverse = (matrix) => Matrix.FromArray(matrix).invert().m;
    const seen = stage.matricesOf(scene.activeCamera);
    const own = camera ? stage.matricesOf(camera) : null;
    const values = {
      ...receiver.vectors,
      ...view.values(seen, own, depth?.isRenderTarget === true, drawn?.floor ?? 0, inverse),
      sandglass_depth_numbers: receiver.numbers,
      ...this.#rays(seen),
    };
    const { material } = mesh;
    for (const [name, value] of Object.entries(values))
      if (value.length === 16) material.setMatrix(name, Matrix.FromArray(value));
      else material.setVector4(name, Vector4.FromArray(value));
  }
  #rays({ view, projection: p }) {
    const { scene } = this.stage;
    const axis = (row) => [view[row], view[4 + row], view[8 + row]];
    const [right, up, back] = [0, 1, 2].map(axis);
    const eye = this.stage.mirrored(scene.activeCamera.globalPosition.asArray());
    const middle = right.map((x, k) => (x * p[8]) / p[0] + (up[k] * p[9]) / p[5] - back[k]);
    const encoded = scene.imageProcessingConfiguration.applyByPostProcess ? 1 : 1 / 2.2;
    return {
      sandglass_middle: [...middle, scene.getEngine().useReverseDepthBuffer ? 0 : 1],
      sandglass_along: [...right.map((x) => x / p[0]), 0],
      sandglass_upwards: [...up.map((x) => x / p[5]), 0],
      sandglass_eye: [...eye, encoded],
    };
  }
  dispose() {
    const { stage, mesh, heights, nothing } = this;
    stage.byDepth.delete(this);
    for (const one of [mesh.material, mesh, heights, nothing]) one?.dispose();
  }
}
