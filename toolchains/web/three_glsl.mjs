// How sand looks by WebGLRenderer: the kit's GLSL in ShaderMaterials, with three's own chunks for depth, clipping, tones and fog.
import { k_block_side } from "./loose_sand.mjs";
import { k_packed_sides, packedBlock } from "./packed_block.mjs";
import { kit } from "./glsl.mjs";
import { blockTexture, sameTexture } from "./three_sand.mjs";

// Sand is lit where it is simulated, wherever its group stands.
const k_camera = `
#define CAMERA_DECLARED
#define view modelViewMatrix
#define projection projectionMatrix`;
const k_vertex_chunks = `
precision highp sampler3D;
#include <common>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
flat out vec3 sand_eye;`;
const k_at_end_of_vertex = `
  sand_eye = -inverse(mat3(view)) * view[3].xyz;
  #include <logdepthbuf_vertex>
  #include <clipping_planes_vertex>
  #include <fog_vertex>`;
const k_fragment_chunks = `
precision highp sampler3D;
#include <common>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
flat in vec3 sand_eye;
// A target of several attachments, as many as WebGL 2 has at least, refuses a shader that leaves one out.
layout(location = 1) out vec4 sand_second;
layout(location = 2) out vec4 sand_third;
layout(location = 3) out vec4 sand_fourth;
#define CAMERA_DECLARED
#define eye sand_eye`;
const k_begin_of_fragment = `
  #include <clipping_planes_fragment>
  #include <logdepthbuf_fragment>`;
const k_at_end_of_fragment = `
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
  #include <fog_fragment>
  sand_second = sand_third = sand_fourth = vec4(0);`;

const k_surface_vertex = `${k_camera}${k_vertex_chunks}
in vec4 sand_normal, sand_origin;
out vec3 sand_world, sand_up;
out vec2 sand_dent_and_height;
flat out vec3 sand_begins;
void main() {
  sand_world = position;
  sand_up = sand_normal.xyz;
  sand_dent_and_height = vec2(sand_normal.w, (sand_origin.w * 65535.0 - 32768.0) * 1e-6);
  sand_begins = sand_origin.xyz * (65535.0 / 65536.0);
  vec4 mvPosition = view * vec4(position, 1);
  gl_Position = projection * mvPosition;
  ${k_at_end_of_vertex}
}`;
const k_surface_fragment = `${k_fragment_chunks}
${kit.uniforms}${kit.light}${kit.sand}${kit.packed}${kit.surface}
in vec3 sand_world, sand_up;
in vec2 sand_dent_and_height;
flat in vec3 sand_begins;
void main() {
  ${k_begin_of_fragment}
  gl_FragColor = vec4(sand_surface(sand_world, sand_up, sand_dent_and_height.x, sand_dent_and_height.y, sand_begins), 1);
  ${k_at_end_of_fragment}
}`;
const k_loose_vertex = `${k_camera}${k_vertex_chunks}
#define eye sand_eye
${kit.uniforms}${kit.light}${kit.sand}${kit.loose}
in vec4 sand_place;
in vec3 sand_way;
in float sand_number;
flat out vec3 loose_stands, loose_up;
flat out float loose_across, loose_own;
flat out uint loose_seed;
out vec2 loose_at;
void main() {
  loose_grain(uint(gl_VertexID), sand_place, sand_way, uint(sand_number));
  gl_Position = grain_position, loose_at = grain_at, loose_across = grain_across;
  loose_stands = grain_stands, loose_up = grain_up, loose_own = grain_own, loose_seed = grain_seed;
  vec4 mvPosition = view * vec4(grain_stands, 1);
  ${k_at_end_of_vertex}
}`;
const k_loose_fragment = `${k_fragment_chunks}
#define view mat4(1)
#define projection mat4(1)
${kit.uniforms}${kit.light}${kit.sand}${kit.loose}
flat in vec3 loose_stands, loose_up;
flat in float loose_across, loose_own;
flat in uint loose_seed;
in vec2 loose_at;
void main() {
  ${k_begin_of_fragment}
  if (grain_lit(loose_at, loose_across) <= 0.0) discard;
  gl_FragColor = vec4(grain_shown(loose_at, loose_across, loose_stands, loose_up, loose_own, loose_seed), 1);
  ${k_at_end_of_fragment}
}`;

export class GlslLook {
  // Which corner of a triangle tells what is flat.
  first = false;

  // `block`: of sandBlock.
  constructor(THREE, block) {
    const { grains, facets } = packedBlock(block);
    this.size = new THREE.Vector4();
    this.uniforms = {
      grains: { value: blockTexture(THREE, grains, k_packed_sides) },
      facets: { value: blockTexture(THREE, facets, k_packed_sides) },
      block_side: { value: k_block_side },
      wet: { value: 0 },
      pixels: { value: 0 },
    };
    const material = (vertexShader, fragmentShader, more) =>
      Object.assign(
        new THREE.ShaderMaterial({
          vertexShader,
          fragmentShader,
          uniforms: { ...THREE.UniformsUtils.clone(THREE.UniformsLib.fog), ...this.uniforms, ...more },
          side: THREE.DoubleSide,
          fog: true,
          clipping: true,
        }),
        { type: "SandglassSand" },
      );
    this.surface = material(k_surface_vertex, k_surface_fragment);
    this.loose = [0, 1].map((flies) => material(k_loose_vertex, k_loose_fragment, { flies: { value: flies } }));
    this.materials = [this.surface, ...this.loose];
  }
  set(values) {
    for (const [name, value] of Object.entries(values)) {
      this.uniforms[name] ??= this.#shared(name);
      this.uniforms[name].value = Array.isArray(value) ? value.flat() : value;
    }
  }
  // A uniform of all materials.
  #shared(name) {
    const made = {};
    for (const { uniforms } of this.materials) uniforms[name] = made;
    return made;
  }
  renew() {
    for (const name of ["grains", "facets"]) this.uniforms[name].value = sameTexture(this.uniforms[name].value);
  }
  // Of a metre at a distance of one, in what is drawn now.
  pixels(renderer, camera) {
    const pixels = 0.5 * renderer.getCurrentViewport(this.size).w * camera.projectionMatrix.elements[5];
    this.uniforms.pixels.value = pixels;
    for (const material of this.loose) material.uniformsNeedUpdate = true;
    return pixels;
  }
  end() {
    for (const material of this.materials) material.dispose();
    for (const name of ["grains", "facets"]) this.uniforms[name].value.dispose();
  }
}
