// What shadows leave of a material's light in Babylon.js: a plugin of PBR materials, in GLSL and WGSL.
import { depthNumbers, receive, receivers, receiverValues } from "./glsl.mjs";
import { ShadowTextures, nothingDrawn } from "./shadow_textures.mjs";
import { k_wgsl } from "./kit_wgsl.mjs";

const k_vectors = Object.keys(receiverValues(nothingDrawn));
// A part's textures in WGSL.
export const texturesOf = (part) =>
  k_wgsl[part].textures
    .map(([name, type]) => `var ${name}: texture_${type.slice(7).toLowerCase()}<f32>;\nvar ${name}Sampler: sampler;`)
    .join("\n");

// In GLSL and in WGSL: how a pair, a colour and a number are declared, and how vectors are called; and what is declared before.
const k_languages = [
  { pair: "vec2", colour: "vec3", number: "float", vec3: "vec3", vec4: "vec4", before: receive },
  {
    pair: "let",
    colour: "var",
    number: "var",
    vec3: "vec3f",
    vec4: "vec4f",
    before: `${texturesOf("receive")}\n${k_wgsl.receive.text}`,
  },
];
// Declarations; what is left of the light; the surface's shadow alone.
const codeOf = ({ pair, colour, number, vec3, vec4, before }, place) => ({
  CUSTOM_FRAGMENT_DEFINITIONS: before,
  CUSTOM_FRAGMENT_BEFORE_FINALCOLORCOMPOSITION: `
${pair} sandglass_rest = sandglass_left(${place});
${colour} sandglass_all = finalDiffuse;
finalDiffuse *= sandglass_rest.x;
${colour} sandglass_some = finalDiffuse;
#ifdef SPECULARTERM
finalSpecularScaled *= sandglass_rest.x;
#endif
#ifdef REFLECTION
sandglass_all += finalIrradiance;
finalIrradiance *= sandglass_rest.y;
sandglass_some += finalIrradiance;
finalRadianceScaled *= sandglass_rest.y;
#endif`,
  CUSTOM_FRAGMENT_BEFORE_FRAGCOLOR: `
#ifdef SANDGLASS_SHADOW_ONLY
${number} sandglass_share = dot(sandglass_some, ${vec3}(1)) / max(dot(sandglass_all, ${vec3}(1)), 1e-6);
#ifndef IMAGEPROCESSINGPOSTPROCESS
sandglass_share = pow(sandglass_share, 1.0 / 2.2);
#endif
finalColor = ${vec4}(${vec3}(0), 1.0 - sandglass_share);
#endif`,
});
const k_places = {
  1: ["vPositionW", "fragmentInputs.vPositionW"],
  "-1": ["vec3(vPositionW.xy, -vPositionW.z)", "vec3f(fragmentInputs.vPositionW.xy, -fragmentInputs.vPositionW.z)"],
};

// Textures of one byte a texel, as a stage gives them.
export const textureMaker = ({ RawTexture, Constants }, scene) => ({
  make(side, bytes) {
    const { TEXTURE_BILINEAR_SAMPLINGMODE, TEXTURETYPE_UNSIGNED_BYTE, TEXTURE_CLAMP_ADDRESSMODE } = Constants;
    const how = [scene, false, false, TEXTURE_BILINEAR_SAMPLINGMODE, TEXTURETYPE_UNSIGNED_BYTE];
    const made = RawTexture.CreateRTexture(bytes.slice(), side, bytes.length / side, ...how);
    made.wrapU = made.wrapV = TEXTURE_CLAMP_ADDRESSMODE;
    made.anisotropicFilteringLevel = 1; // more would read other layers where two meet
    return made;
  },
  fill: (texture, bytes) => texture.update(bytes.slice()),
});

const owners = new WeakMap(); // by material: its plugin

// The base class asks for code before there are fields.
const pluginOf = (BABYLON, z) =>
  class extends BABYLON.MaterialPluginBase {
    constructor(material) {
      super(material, "SandglassReceiver", 200, { SANDGLASS_VECTORS_DECLARED: false, SANDGLASS_SHADOW_ONLY: false });
    }
    getClassName() {
      return "SandglassReceiver";
    }
    isCompatible() {
      return true;
    }
    // Shows a receiver's shadows from now on; null: none.
    show(receiver, shadowOnly) {
      this.receiver?.plugins.delete(this);
      receiver?.plugins.add(this);
      Object.assign(this, { receiver, shadowOnly });
      this._enable(receiver !== null);
      this.markAllDefinesAsDirty();
    }
    prepareDefines(defines) {
      defines.SANDGLASS_VECTORS_DECLARED = true;
      defines.SANDGLASS_SHADOW_ONLY = this.shadowOnly;
    }
    getSamplers(samplers) {
      samplers.push(...receivers.map((name) => `sandglass_${name}`));
    }
    getUniforms() {
      return {
        ubo: k_vectors.map((name) => ({ name, size: 4, type: "vec4" })),
        fragment: k_vectors.map((name) => `uniform vec4 ${name};`).join("\n"),
      };
    }
    bindForSubMesh(buffer) {
      if (!this.receiver) return;
      const { vectors, textures } = this.receiver;
      for (const name of k_vectors) buffer.updateFloat4(name, ...vectors[name]);
      for (const name of receivers) buffer.setTexture(`sandglass_${name}`, textures.all[name]);
    }
    getCustomCode(kind, language) {
      const which = language === 1 ? 1 : 0;
      return kind === "fragment" ? codeOf(k_languages[which], k_places[z][which]) : null;
    }
  };

export class BabylonReceiver {
  // `z`: -1 where the scene is left-handed.
  constructor(BABYLON, scene, z) {
    Object.assign(this, { plugins: new Set(), Plugin: pluginOf(BABYLON, z) });
    this.textures = new ShadowTextures(textureMaker(BABYLON, scene), () => {});
    this.set(nothingDrawn, []);
  }
  receive(material, shadowOnly) {
    const kind = material?.getClassName?.() ?? "thing without a class name";
    if (!/^PBR/.test(kind))
      throw new Error(
        `sandglass: no shadow falls on a ${kind}: Babylon.js does not light it by harmonics. Take a PBRMaterial.`,
      );
    if (!owners.has(material)) owners.set(material, new this.Plugin(material));
    owners.get(material).show(this, shadowOnly);
  }
  // It shows no shadows any more.
  stop(material) {
    const plugin = owners.get(material);
    if (plugin?.receiver === this) plugin.show(null, false);
  }
  // `changed`: names of textures.
  set(drawn, changed) {
    this.vectors = receiverValues(drawn);
    this.numbers = depthNumbers(drawn);
    for (const name of changed) this.textures.show(name, drawn.textures[name]);
  }
  end() {
    for (const plugin of [...this.plugins]) plugin.show(null, false);
    this.textures.end();
  }
}
