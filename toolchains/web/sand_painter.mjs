// Draws a skin of the library with the sand kit by WebGL 2: the chunks of the mesh that changed are uploaded, and the loose
// sand is drawn as squares, an instance a particle.
import { k_kit } from "./kit.mjs";
import { grainsNeeded, k_block_side, looseValues, squareIndices } from "./loose_sand.mjs";
import { k_loose_words, k_vertex_bytes } from "./skin_changes.mjs";

const k_block_texels = 64;
const k_loose_bytes = 4 * k_loose_words;
const k_block_unit = 8; // of the painter's textures; those below are others
const k_loose_vertex = `#define FLOAT_NUMBER\n${k_kit.loose_vert}`;

// Compiles for WebGL 2. `at` gives the place of a uniform, and is the first that waits for the compiler.
export function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, body] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(
      shader,
      `#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler3D;\n${body}`,
    );
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  const at = new Map();
  return {
    made,
    at: (name) => {
      if (at.size === 0 && !gl.getProgramParameter(made, gl.LINK_STATUS))
        throw new Error(
          `This browser refuses a shader: ${[gl.getProgramInfoLog(made), ...gl.getAttachedShaders(made).map((shader) => gl.getShaderInfoLog(shader))].join(" ")}`,
        );
      if (!at.has(name)) at.set(name, gl.getUniformLocation(made, name));
      return at.get(name);
    },
  };
}

// Of any names; their kind is told by the value.
export function setUniforms(gl, { at }, values) {
  for (const [name, value] of Object.entries(values)) {
    if (typeof value === "number") gl.uniform1f(at(name), value);
    else if (value.length === 16) gl.uniformMatrix4fv(at(name), false, value);
    else if (value.length === 9) gl.uniformMatrix3fv(at(name), false, value);
    else if (value[0].length === 4) gl.uniform4fv(at(name), value.flat());
    else gl[value.length === 4 ? "uniform4fv" : "uniform3fv"](at(name), value);
  }
}

// A texture that a stage gives. `made`: what this gave before.
export function uploadShadow(gl, { side, bytes }, made = gl.createTexture()) {
  gl.bindTexture(gl.TEXTURE_2D, made);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
  for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, side, side, 0, gl.RED, gl.UNSIGNED_BYTE, bytes);
  return made;
}

export class SandPainter {
  // `hidden`: GLSL, how much something real hides of a place; `block`: of sandBlock; `radius`: a particle's.
  constructor(gl, hidden, block, radius) {
    const before = k_kit.uniforms + k_kit.light;
    this.gl = gl;
    this.radius = radius;
    this.chunks = [];
    this.counts = [0, 0];
    this.surface = program(
      gl,
      before + k_kit.surface_vert,
      before + hidden + k_kit.sand + k_kit.levels + k_kit.surface + k_kit.surface_frag,
    );
    this.loose = program(
      gl,
      before + k_kit.sand + k_kit.loose + k_loose_vertex,
      before + hidden + k_kit.sand + k_kit.loose + k_kit.loose_frag,
    );
    this.looseBuffer = gl.createBuffer();
    this.looseArray = gl.createVertexArray();
    this.streams = [];
    this.wet = 0;
    this.share = 1;
    gl.bindVertexArray(this.looseArray);
    this.squares = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.squares);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, squareIndices(), gl.STATIC_DRAW);
    for (const at of [0, 1, 2]) {
      gl.enableVertexAttribArray(at);
      gl.vertexAttribDivisor(at, 1);
    }
    gl.bindVertexArray(null);
    this.block = [0, 1].map((which) => this.blockTexture(block, which));
  }

  blockTexture(block, which) {
    const { gl } = this;
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_3D, made);
    for (let side = block.length > 8 ? k_block_texels : 1, level = 0, at = 0; side >= 1; side >>= 1, ++level) {
      const bytes = 4 * side ** 3;
      gl.texImage3D(
        gl.TEXTURE_3D,
        level,
        gl.RGBA8,
        side,
        side,
        side,
        0,
        gl.RGBA,
        gl.UNSIGNED_BYTE,
        block.subarray(at + which * bytes, at + (which + 1) * bytes),
      );
      at += 2 * bytes;
    }
    for (const [name, value] of [
      [gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR],
      [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.REPEAT],
      [gl.TEXTURE_WRAP_T, gl.REPEAT],
      [gl.TEXTURE_WRAP_R, gl.REPEAT],
    ])
      gl.texParameteri(gl.TEXTURE_3D, name, value);
    return made;
  }

  newChunk() {
    const { gl } = this;
    const chunk = { count: 0, array: gl.createVertexArray(), vertices: gl.createBuffer(), indices: gl.createBuffer() };
    gl.bindVertexArray(chunk.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, chunk.vertices);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, chunk.indices);
    [
      [3, gl.FLOAT, 0],
      [3, gl.BYTE, 12],
      [1, gl.UNSIGNED_BYTE, 15],
      [3, gl.UNSIGNED_SHORT, 16],
      [1, gl.SHORT, 22],
    ].forEach(([size, type, offset], at) => {
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, type, type !== gl.FLOAT, k_vertex_bytes, offset);
    });
    gl.bindVertexArray(null);
    return chunk;
  }

  // What it holds of the context.
  end() {
    const { gl } = this;
    for (const { array, vertices, indices } of this.chunks) {
      gl.deleteVertexArray(array);
      gl.deleteBuffer(vertices);
      gl.deleteBuffer(indices);
    }
    gl.deleteVertexArray(this.looseArray);
    for (const buffer of [this.looseBuffer, this.squares]) gl.deleteBuffer(buffer);
    for (const { made } of [this.surface, this.loose]) gl.deleteProgram(made);
    for (const texture of this.block) gl.deleteTexture(texture);
  }
  // Another skin comes.
  clear() {
    for (const chunk of this.chunks) chunk.count = 0;
  }
  // `changes`: of SkinChanges.
  upload({ chunks, flying, lying, loose }) {
    const { gl } = this;
    for (const { number, vertices, indices } of chunks) {
      while (this.chunks.length <= number) this.chunks.push(this.newChunk()); // any may be made first
      const chunk = this.chunks[number];
      chunk.count = indices.length;
      gl.bindBuffer(gl.ARRAY_BUFFER, chunk.vertices);
      gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.DYNAMIC_DRAW);
      gl.bindVertexArray(chunk.array);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.DYNAMIC_DRAW);
      gl.bindVertexArray(null);
    }
    this.counts = [flying, lying];
    this.particles = loose;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.looseBuffer);
    gl.bufferData(gl.ARRAY_BUFFER, loose, gl.STREAM_DRAW);
  }
  // `common(program)` sets the uniforms of view, light and shadows; `height`: of the picture, pixels.
  draw(common, view, projection, height) {
    const {
      gl,
      surface,
      loose,
      counts: [flying, lying],
    } = this;
    const pixels = 0.5 * height * Math.abs(projection[5]); // the picture may be upside down
    const own = (p) => {
      common(p);
      this.block.forEach((texture, k) => {
        gl.activeTexture(gl.TEXTURE0 + k_block_unit + k);
        gl.bindTexture(gl.TEXTURE_3D, texture);
      });
      gl.activeTexture(gl.TEXTURE0);
      gl.uniform1i(p.at("grains"), k_block_unit);
      gl.uniform1i(p.at("facets"), k_block_unit + 1);
      gl.uniform1f(p.at("block_side"), k_block_side);
      gl.uniform1f(p.at("wet"), this.wet);
    };
    const chunks = this.chunks.filter(({ count }) => count > 0);
    if (chunks.length > 0) own(surface); // a program that draws nothing is not waited for
    for (const { array, count } of chunks) {
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_SHORT, 0);
    }
    gl.bindVertexArray(null);
    if (flying + lying === 0) return;
    own(loose);
    setUniforms(gl, loose, { ...looseValues(this.radius, this.streams), pixels });
    gl.bindVertexArray(this.looseArray);
    const lists = [
      [flying, 0, 1],
      [lying, flying, 0],
    ];
    gl.bindBuffer(gl.ARRAY_BUFFER, this.looseBuffer);
    for (const [count, first, flies] of lists) {
      if (count === 0) continue;
      const at = k_loose_bytes * first;
      gl.vertexAttribPointer(0, 4, gl.FLOAT, false, k_loose_bytes, at);
      gl.vertexAttribPointer(1, 3, gl.FLOAT, false, k_loose_bytes, at + 16);
      gl.vertexAttribPointer(2, 1, gl.FLOAT, false, k_loose_bytes, at + 28);
      gl.uniform1f(loose.at("flies"), flies);
      const particles = this.particles.subarray(k_loose_words * first, k_loose_words * (first + count));
      const grains = grainsNeeded(flies, particles, view, projection, pixels, this.share);
      gl.drawElementsInstanced(gl.TRIANGLES, 6 * grains, gl.UNSIGNED_SHORT, 0, count);
    }
    gl.bindVertexArray(null);
  }
}
