// What shadows leave of a material's light under WebGLRenderer: the shader of a classic material is patched, once for good; whose
// shadows it shows can change, and end.
import { byDepth, depthNumbers, receive, receivers, receiverValues } from "./glsl.mjs";
import { ShadowTextures, nothingDrawn } from "./shadow_textures.mjs";
import { textureMaker } from "./three_sand.mjs";

const k_lit = ["MeshStandardMaterial", "MeshPhysicalMaterial", "MeshLambertMaterial", "MeshPhongMaterial"];
const k_world = `
  vec4 sandglass_place = vec4(transformed, 1);
  #ifdef USE_BATCHING
  sandglass_place = batchingMatrix * sandglass_place;
  #endif
  #ifdef USE_INSTANCING
  sandglass_place = instanceMatrix * sandglass_place;
  #endif
  sandglass_world = (modelMatrix * sandglass_place).xyz;`;
const k_left = `
  vec3 sandglass_all = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
  vec2 sandglass_rest = sandglass_left(sandglass_world);
  reflectedLight.directDiffuse *= sandglass_rest.x;
  reflectedLight.directSpecular *= sandglass_rest.x;
  reflectedLight.indirectDiffuse *= sandglass_rest.y;
  reflectedLight.indirectSpecular *= sandglass_rest.y;`;
const k_shadow_only = `
  vec3 sandglass_some = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
  float sandglass_share = dot(sandglass_some, vec3(1)) / max(dot(sandglass_all, vec3(1)), 1e-6);
  gl_FragColor = vec4(vec3(0), 1.0 - linearToOutputTexel(vec4(sandglass_share)).r);`;

const k_over_vertex = `
out vec2 sandglass_on;
out vec3 sandglass_ray;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  sandglass_on = 0.5 + vec2(0.5, -0.5) * corner;
  vec2 way = (corner + projectionMatrix[2].xy) / vec2(projectionMatrix[0].x, projectionMatrix[1].y);
  sandglass_ray = transpose(mat3(viewMatrix)) * vec3(way, -1);
  gl_Position = vec4(corner, 1, 1);
  #ifdef USE_REVERSED_DEPTH_BUFFER
  gl_Position.z = 0.0;
  #endif
}`;
const k_over_fragment = `
precision highp sampler2D;
in vec2 sandglass_on;
in vec3 sandglass_ray;
${byDepth}
void main() {
  float share = sandglass_left_by_depth(sandglass_on, cameraPosition, sandglass_ray);
  gl_FragColor = vec4(vec3(0), 1.0 - linearToOutputTexel(vec4(share)).r);
}`;

const patched = new WeakMap(); // what each material's shader reads
const nothing = new WeakMap(); // by three: a texture for what shows no shadow

// Puts lines after, or in place of, one of three's chunks.
function put(text, chunk, lines, replaced = false) {
  const anchor = `#include <${chunk}>`;
  if (!text.includes(anchor))
    console.error(
      `sandglass: a material that receives shadows has no ${anchor} in its shader, so it shows none. Receive with a material of three's own.`,
    );
  return text.replace(anchor, replaced ? lines : `${anchor}\n${lines}`);
}

function patch(material) {
  const uniforms = {};
  const before = material.onBeforeCompile;
  const key = material.customProgramCacheKey();
  const kept = { uniforms, shadowOnly: false };
  material.onBeforeCompile = (shader, renderer) => {
    before.call(material, shader, renderer);
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = put(shader.vertexShader, "common", "varying vec3 sandglass_world;");
    shader.vertexShader = put(shader.vertexShader, "project_vertex", k_world);
    let text = put(shader.fragmentShader, "common", `varying vec3 sandglass_world;\n${receive}`);
    text = put(text, "aomap_fragment", k_left);
    if (kept.shadowOnly) text = put(text, "opaque_fragment", k_shadow_only, true);
    shader.fragmentShader = text;
  };
  material.customProgramCacheKey = () => `${key} sandglass ${kept.shadowOnly}`;
  return kept;
}

export class GlslReceiver {
  constructor(THREE) {
    this.THREE = THREE;
    this.materials = new Set();
    this.values = {};
    this.textures = new ShadowTextures(textureMaker(THREE), (name, texture) => {
      this.values[`sandglass_${name}`] = texture;
      for (const material of this.materials) this.#bind(material);
    });
    this.set(nothingDrawn, []);
  }
  receive(material, shadowOnly) {
    if (!k_lit.includes(material?.type))
      throw new Error(
        `sandglass: no shadow falls on a ${material?.type ?? "thing without a type"}. receive takes the material of a mesh, which three lights: a MeshStandardMaterial.`,
      );
    if (!patched.has(material)) patched.set(material, patch(material));
    const kept = patched.get(material);
    kept.owner?.materials.delete(material);
    Object.assign(kept, { owner: this, shadowOnly });
    this.materials.add(material);
    this.#bind(material);
    material.needsUpdate = true;
  }
  // A material that is drawn over the whole picture, by what a depth texture tells.
  byDepth(values, options) {
    const uniforms = {};
    const shaders = { vertexShader: k_over_vertex, fragmentShader: k_over_fragment };
    const material = Object.assign(new this.THREE.ShaderMaterial({ ...shaders, ...options }), { uniforms });
    patched.set(material, { uniforms, owner: this, shadowOnly: true });
    this.materials.add(material);
    this.#bind(material);
    this.showDepth(material, values);
    return material;
  }
  showDepth(material, values) {
    for (const [name, value] of Object.entries(values)) (material.uniforms[name] ??= {}).value = value;
    material.uniformsNeedUpdate = true;
  }
  // It shows no shadows any more.
  stop(material) {
    if (!this.materials.delete(material)) return;
    const { uniforms } = patched.get(material);
    const { THREE } = this;
    if (!nothing.has(THREE)) nothing.set(THREE, textureMaker(THREE).make(1, Uint8Array.of(255)));
    for (const name of receivers) uniforms[`sandglass_${name}`].value = nothing.get(THREE);
    uniforms.sandglass_numbers.value = new THREE.Vector4();
    uniforms.sandglass_occlusion_box.value = new THREE.Vector4(2, 2, 0, 0);
  }
  // `changed`: names of textures.
  set(drawn, changed) {
    const values = { ...receiverValues(drawn), sandglass_depth_numbers: depthNumbers(drawn) };
    for (const [name, value] of Object.entries(values))
      (this.values[name] ??= new this.THREE.Vector4()).fromArray(value);
    for (const name of changed) this.textures.show(name, drawn.textures[name]);
  }
  end() {
    for (const material of [...this.materials]) this.stop(material);
    this.textures.end();
  }
  #bind(material) {
    const { uniforms } = patched.get(material);
    for (const [name, value] of Object.entries(this.values)) (uniforms[name] ??= {}).value = value;
  }
}
