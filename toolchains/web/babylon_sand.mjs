// Sand in a scene of Babylon.js: a mesh for each chunk, and one each for what lies and flies alone. Their material is the engine's
// own, unlit, with a plugin in GLSL or WGSL that makes its colour; tones, fog, clipping and depth are therefore the engine's.
import { grainsNeeded, k_block_side, looseValues, squareIndices } from "./loose_sand.mjs";
import { chunkArrays, looseLists } from "./sand_geometry.mjs";
import { kit, kitValues } from "./glsl.mjs";
import { k_packed_sides, packedBlock } from "./packed_block.mjs";
import { k_wgsl } from "./kit_wgsl.mjs";
import { ShadowTextures, nothingDrawn, showOnSand } from "./shadow_textures.mjs";
import { textureMaker, texturesOf } from "./babylon_receive.mjs";

const k_sizes = { float: 1, vec3: 3, vec4: 4, mat4: 16 };

// What is declared once in each stage of a shader, by language: sand is lit where it is simulated, wherever its meshes stand.
const samplers = (part) => k_wgsl[part].textures.map(([name, type]) => `uniform highp ${type} ${name};`).join("\n");
const k_glsl_camera = `
precision highp sampler3D;
mat4 sand_view, sand_projection;
vec3 sand_eye;
#define view sand_view
#define projection sand_projection
#define eye sand_eye
#define table_of_room mat3(1)`;
const k_glsl_camera_ends = `
#undef view
#undef projection
#undef eye`;
const glsl = (part, ...texts) => `${k_glsl_camera}\n${samplers(part)}\n${texts.join("")}${k_glsl_camera_ends}`;
const wgsl = (part) => `${texturesOf(part)}\n${k_wgsl[part].text}`;
const k_wgsl_handed = `flat varying loose_stands: vec3f;
flat varying loose_up: vec3f;
flat varying loose_own: f32;
flat varying loose_seed: u32;
flat varying loose_across: f32;
varying loose_at: vec2f;`;
// Else the engine encodes by a power of 2.2.
const k_exact = "#ifndef USE_EXACT_SRGB_CONVERSIONS\n#define USE_EXACT_SRGB_CONVERSIONS\n#endif";
const k_identity = "mat3x3f(1, 0, 0, 0, 1, 0, 0, 0, 1)";

// By part and language: what is added to the engine's vertex and fragment shaders: declarations, statements at the end, and where a
// place in the world is made.
const k_code = {
  surface: [
    {
      vertex: [
        `attribute vec4 sand_normal, sand_origin;
out vec3 sand_world, sand_up;
out vec2 sand_dent_and_height;
flat out vec3 sand_begins;`,
        `sand_world = position;
sand_up = sand_normal.xyz;
sand_dent_and_height = vec2(sand_normal.w, (sand_origin.w * 65535.0 - 32768.0) * 1e-6);
sand_begins = sand_origin.xyz * (65535.0 / 65536.0);`,
      ],
      fragment: [
        `in vec3 sand_world, sand_up;
in vec2 sand_dent_and_height;
flat in vec3 sand_begins;
${glsl("surface", kit.light, kit.sand, kit.packed, kit.surface)}`,
        `sand_eye = (sand_from_world * vec4(vEyePosition.xyz, 1)).xyz;
finalDiffuse = sand_surface(sand_world, sand_up, sand_dent_and_height.x, sand_dent_and_height.y, sand_begins);`,
      ],
    },
    {
      vertex: [
        `attribute sand_normal: vec4f;
attribute sand_origin: vec4f;
varying sand_world: vec3f;
varying sand_up: vec3f;
varying sand_dent_and_height: vec2f;
flat varying sand_begins: vec3f;`,
        `vertexOutputs.sand_world = vertexInputs.position;
vertexOutputs.sand_up = vertexInputs.sand_normal.xyz;
vertexOutputs.sand_dent_and_height = vec2f(vertexInputs.sand_normal.w, (vertexInputs.sand_origin.w * 65535.0 - 32768.0) * 1e-6);
vertexOutputs.sand_begins = vertexInputs.sand_origin.xyz * (65535.0 / 65536.0);`,
      ],
      fragment: [
        `varying sand_world: vec3f;
varying sand_up: vec3f;
varying sand_dent_and_height: vec2f;
flat varying sand_begins: vec3f;
${wgsl("surface")}`,
        `eye = (uniforms.sand_from_world * vec4f(scene.vEyePosition.xyz, 1)).xyz;
table_of_room = ${k_identity};
finalDiffuse = sand_surface(fragmentInputs.sand_world, fragmentInputs.sand_up, fragmentInputs.sand_dent_and_height.x, fragmentInputs.sand_dent_and_height.y, fragmentInputs.sand_begins);`,
      ],
    },
  ],
  loose: [
    {
      vertex: [
        `attribute vec4 sand_place;
attribute vec3 sand_way;
attribute float sand_number;
flat out vec3 loose_stands, loose_up;
flat out float loose_across, loose_own;
flat out uint loose_seed;
out vec2 loose_at;
${glsl("loose", kit.light, kit.sand, kit.loose)}`,
        `gl_Position = grain_position;
loose_across = grain_across;
loose_at = grain_at;
loose_stands = grain_stands;
loose_up = grain_up;
loose_own = grain_own;
loose_seed = grain_seed;`,
        `sand_view = view * world;
sand_projection = projection;
sand_eye = (sand_from_world * vec4(vEyePosition.xyz, 1)).xyz;
loose_grain(uint(gl_VertexID), sand_place, sand_way, uint(sand_number));
worldPos = world * vec4(grain_stands, 1);`,
      ],
      fragment: [
        `flat in vec3 loose_stands, loose_up;
flat in float loose_across, loose_own;
flat in uint loose_seed;
in vec2 loose_at;
${glsl("loose", kit.light, kit.sand, kit.loose)}`,
        `if (grain_lit(loose_at, loose_across) <= 0.0) discard;
sand_eye = (sand_from_world * vec4(vEyePosition.xyz, 1)).xyz;
finalDiffuse = grain_shown(loose_at, loose_across, loose_stands, loose_up, loose_own, loose_seed);`,
      ],
    },
    {
      vertex: [
        `attribute sand_place: vec4f;
attribute sand_way: vec3f;
attribute sand_number: f32;
${k_wgsl_handed}
${wgsl("loose")}`,
        `vertexOutputs.position = grain_position;
vertexOutputs.loose_stands = grain_stands;
vertexOutputs.loose_up = grain_up;
vertexOutputs.loose_own = grain_own;
vertexOutputs.loose_seed = grain_seed;
vertexOutputs.loose_across = grain_across;
vertexOutputs.loose_at = grain_at;`,
        `view = scene.view * mesh.world;
projection = scene.projection;
eye = (uniforms.sand_from_world * vec4f(scene.vEyePosition.xyz, 1)).xyz;
table_of_room = ${k_identity};
loose_grain(vertexInputs.vertexIndex, vertexInputs.sand_place, vertexInputs.sand_way, u32(vertexInputs.sand_number));
worldPos = mesh.world * vec4f(grain_stands, 1);`,
      ],
      fragment: [
        `${k_wgsl_handed}
${wgsl("loose")}`,
        `if (grain_lit(fragmentInputs.loose_at, fragmentInputs.loose_across) <= 0.0) { discard; }
eye = (uniforms.sand_from_world * vec4f(scene.vEyePosition.xyz, 1)).xyz;
table_of_room = ${k_identity};
finalDiffuse = grain_shown(fragmentInputs.loose_at, fragmentInputs.loose_across, fragmentInputs.loose_stands, fragmentInputs.loose_up, fragmentInputs.loose_own, fragmentInputs.loose_seed);`,
      ],
    },
  ],
};
const k_attributes = {
  surface: ["sand_normal", "sand_origin"],
  loose: ["sand_place", "sand_way", "sand_number"],
};

// A plugin of materials. `values`: of the uniforms, with textures; the base class asks for code before there are fields.
const pluginOf = (BABYLON, part, values, matrix = new BABYLON.Matrix()) =>
  class extends BABYLON.MaterialPluginBase {
    constructor(material) {
      super(material, "SandglassSand", 200, { SANDGLASS_SAND: false });
      this._enable(true);
    }
    getClassName() {
      return "SandglassSand";
    }
    isCompatible() {
      return true;
    }
    prepareDefines(defines) {
      defines.SANDGLASS_SAND = true;
    }
    getAttributes(attributes) {
      attributes.push(...k_attributes[part]);
    }
    getSamplers(names) {
      names.push(...k_wgsl[part].textures.map(([name]) => name));
    }
    getUniforms() {
      const ubo = [["sand_from_world", "mat4", 0], ...k_wgsl[part].uniforms];
      return { ubo: ubo.map(([name, type, arraySize]) => ({ name, type, size: k_sizes[type], arraySize })) };
    }
    bindForSubMesh(buffer, scene, engine, subMesh) {
      subMesh.getMesh().getWorldMatrix().invertToRef(matrix);
      buffer.updateMatrix("sand_from_world", matrix);
      for (const [name, type, count] of k_wgsl[part].uniforms) {
        const value = values[name];
        if (count > 0) buffer.updateArray(name, value.flat());
        else if (type === "mat4") {
          BABYLON.Matrix.FromArrayToRef(value, 0, matrix);
          buffer.updateMatrix(name, matrix);
        } else if (type === "float") buffer.updateFloat(name, value);
        else buffer[type === "vec3" ? "updateFloat3" : "updateFloat4"](name, ...value);
      }
      for (const [name] of k_wgsl[part].textures) buffer.setTexture(name, values[name]);
    }
    getCustomCode(kind, language) {
      const code = k_code[part][language === 1 ? 1 : 0][kind];
      if (!code) return null;
      const ends = kind === "vertex" ? "CUSTOM_VERTEX_MAIN_END" : "CUSTOM_FRAGMENT_BEFORE_FINALCOLORCOMPOSITION";
      const place = code[2] ? { CUSTOM_VERTEX_UPDATE_WORLDPOS: code[2] } : {};
      const exact = kind === "fragment" ? { CUSTOM_FRAGMENT_BEGIN: k_exact } : {};
      return { [`CUSTOM_${kind.toUpperCase()}_DEFINITIONS`]: code[0], [ends]: code[1], ...place, ...exact };
    }
  };

export class BabylonSand {
  // `z`: -1 where the scene is left-handed; `radius`: a particle's.
  constructor(BABYLON, scene, z, block, radius) {
    const { grains, facets } = packedBlock(block);
    this.root = new BABYLON.Mesh("sand", scene);
    this.root.scaling.z = z;
    Object.assign(this, {
      BABYLON,
      scene,
      radius,
      chunks: [],
      loose: [],
      particles: [],
      buffers: [],
      first: scene.getEngine().isWebGPU === true,
    });
    this.values = { block_side: k_block_side, wet: 0, pixels: 0 };
    for (const [name, bytes] of Object.entries({ grains, facets })) this.values[name] = this.#block(bytes);
    this.textures = new ShadowTextures(textureMaker(BABYLON, scene), (name, texture) => (this.values[name] = texture));
    this.surface = this.#material("surface", this.values);
    this.take(nothingDrawn);
    this.loose = [0, 1].map((flies) => this.#looseMesh(flies));
  }

  take(drawn) {
    showOnSand(this.textures, drawn);
    Object.assign(this.values, kitValues(drawn), looseValues(this.radius, drawn.streams ?? []));
    this.#takeDepth();
    if (!drawn.skin) return;
    for (const chunk of drawn.skin.chunks) this.#takeChunk(chunk);
    looseLists(drawn.skin).forEach((particles, flies) => this.#takeLoose(flies, particles));
  }
  // Depth is logarithmic where materials of the scene say so.
  #takeDepth() {
    const of_sand = (one) => one.pluginManager?.getPlugin("SandglassSand");
    const is = this.scene.materials.some((one) => one.useLogarithmicDepth && !of_sand(one));
    for (const one of [this.surface, ...this.loose.map((mesh) => mesh.material)]) one.useLogarithmicDepth = is;
  }
  // What it holds of the engine.
  end() {
    this.root.dispose(false, true);
    this.surface.dispose();
    for (const buffer of this.buffers) buffer?.dispose(); // of what is loose
    this.textures.end();
    for (const name of ["grains", "facets"]) this.values[name].dispose();
  }

  #material(part, values) {
    const { BABYLON, scene } = this;
    const material = new BABYLON.PBRMaterial("sand", scene);
    Object.assign(material, { unlit: true, backFaceCulling: false });
    const Plugin = pluginOf(BABYLON, part, values);
    new Plugin(material);
    return material;
  }
  #block(bytes) {
    const { RawTexture3D, Constants } = this.BABYLON;
    const { TEXTUREFORMAT_RGBA, TEXTURE_BILINEAR_SAMPLINGMODE } = Constants;
    const sampling = [TEXTUREFORMAT_RGBA, this.scene, false, false, TEXTURE_BILINEAR_SAMPLINGMODE];
    return new RawTexture3D(bytes, ...k_packed_sides, ...sampling);
  }

  #mesh(material) {
    const mesh = new this.BABYLON.Mesh("sand", this.scene, this.root);
    mesh.material = material;
    mesh.isVisible = false;
    return mesh;
  }
  #takeChunk({ number, ...chunk }) {
    const { BABYLON, chunks, scene } = this;
    while (chunks.length <= number) chunks.push(this.#mesh(this.surface)); // any may be made first
    const mesh = chunks[number];
    mesh.isVisible = chunk.indices.length > 0;
    if (!mesh.isVisible) return;
    const { positions, normals, origins, indices } = chunkArrays(chunk, this.first);
    const { BYTE, UNSIGNED_SHORT } = BABYLON.VertexBuffer;
    const put = (kind, data, size, type) =>
      mesh.setVerticesBuffer(
        new BABYLON.VertexBuffer(scene.getEngine(), data, kind, { size, ...(type ? { type, normalized: true } : {}) }),
      );
    put("position", positions, 3);
    put("sand_normal", normals, 4, BYTE);
    put("sand_origin", origins, 4, UNSIGNED_SHORT);
    mesh.setIndices(indices, positions.length / 3);
  }

  #looseMesh(flies) {
    const values = Object.create(this.values, { flies: { value: flies }, pixels: { value: 0, writable: true } });
    const mesh = this.#mesh(this.#material("loose", values));
    mesh.isPickable = false; // a ray hits the mesh
    mesh.alwaysSelectAsActiveMesh = true;
    const view = new this.BABYLON.Matrix();
    mesh.onBeforeRenderObservable.add(() => {
      const { scene } = this;
      const camera = scene.activeCamera;
      const engine = scene.getEngine();
      const { m } = camera.getProjectionMatrix();
      values.pixels = 0.5 * engine.getRenderHeight() * camera.viewport.height * m[5];
      mesh.getWorldMatrix().multiplyToRef(camera.getViewMatrix(), view);
      mesh.subMeshes[0].indexCount = 6 * grainsNeeded(flies, this.particles[flies], view.m, m, values.pixels);
    });
    return mesh;
  }
  #takeLoose(flies, particles) {
    const { BABYLON, scene } = this;
    const mesh = this.loose[flies];
    const count = particles.length / 8;
    this.particles[flies] = particles;
    mesh.isVisible = count > 0;
    if (!mesh.isVisible) return;
    const buffer = new BABYLON.Buffer(scene.getEngine(), particles.slice(), false, 8, false, true);
    for (const [kind, at, size] of [
      ["position", 0, 3],
      ["sand_place", 0, 4],
      ["sand_way", 4, 3],
      ["sand_number", 7, 1],
    ])
      mesh.setVerticesBuffer(buffer.createVertexBuffer(kind, at, size, 8, true));
    this.buffers[flies]?.dispose();
    this.buffers[flies] = buffer;
    if (mesh.getTotalIndices() === 0) mesh.setIndices(squareIndices(), 4);
    mesh.forcedInstanceCount = count;
  }
}
