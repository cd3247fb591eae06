// Draws the table, the object and the sand with WebGL 2. Colours are linear until a shader's last line. The sand is drawn by
// the sand kit (models/kit, sand_painter.mjs). Shadows are the library's own textures: of the sharp main
// light, and of the light from all around, which object and sand keep from the table, and the sand from itself. Over a
// camera's image table and wall get shadows alone, and what is real hides what is drawn behind it
// (runtime/shadow/README.md). Metal reflects the room's cube, or the sliders' sky, and the table.
import { SandPainter, program, setUniforms, uploadShadow } from "./sand_painter.mjs";
import { kitValues } from "./glsl.mjs";
import { k_kit } from "./kit.mjs";

const k_depth_bias = 0.02; // metres
const k_samples = 4; // of a smooth pixel
const k_nothing = { side: 1, bytes: new Uint8Array(1) };
const k_textures = [
  "pile",
  "onSand",
  "shadow",
  "occlusion",
  "sky",
  "skyOnSand",
  "wallShadow",
  "wallOcclusion",
  "depth",
];
const k_plain = Uint8Array.of(197, 165, 122, 168, 127, 127, 128, 130); // a block without grains: the last level of the one with them

const k_hidden = `
uniform sampler2D real_depth;    // of the camera, metres along its axis; 0: not known
uniform mat3 depth_from_screen;  // where a pixel lies in it
uniform vec4 wall;               // a place's distance from it
uniform float bias;              // metres that the depth may be wrong by
// How much something real hides of what is drawn. What the camera shows on table or wall is table or wall.
float hidden(vec3 place) {
  ivec2 size = textureSize(real_depth, 0);
  if (size.x == 1) return 0.0;  // nothing is known
  vec2 at = (depth_from_screen * vec3(gl_FragCoord.xy, 1)).xy * vec2(size) - 0.5, part = fract(at);
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    float real = texelFetch(real_depth, clamp(ivec2(floor(at)) + corner, ivec2(0), size - 1), 0).r;
    float drawn = 1.0 / gl_FragCoord.w, eye_from_wall = dot(wall, vec4(eye, 1)), from_wall = dot(wall, vec4(place, 1));
    float before = min(sandglass_before(real, drawn, eye.y, place.y, bias), sandglass_before(real, drawn, eye_from_wall, from_wall, bias));
    vec2 weight = mix(1.0 - part, part, vec2(corner));
    sum += weight.x * weight.y * (real > 0.0 ? smoothstep(bias, 2.0 * bias, before) : 0.0);
  }
  return sum;
}`;
const k_lighting = k_kit.uniforms + k_kit.light + k_kit.before + k_hidden;

const k_solid_vertex = `
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;  // of metal
uniform mat4 model, view, projection;
out vec3 world, smooth_normal;
void main() {
  world = (model * vec4(position, 1)).xyz;
  smooth_normal = mat3(model) * normal;
  gl_Position = projection * view * vec4(world, 1);
}`;
const k_solid_fragment = `
in vec3 world, smooth_normal;
uniform vec3 albedo;
uniform float table;  // 2: what is real, of which the shadow alone is drawn; 1: the table's top, round; 0: an object
uniform float metal, real;
uniform samplerCube room;
uniform float room_known;
out vec4 pixel;
${k_lighting}
const vec3 k_floor = vec3(0.66, 0.62, 0.56), k_around = vec3(0.62, 0.60, 0.56);  // of a studio
vec3 table_top(vec3 place) {
  vec3 lit = shade(k_floor, vec3(0, 1, 0), object_passed(place) * pile_passed(place), opened(place) * under_sky(place));
  return mix(lit, k_around, smoothstep(0.5, 2.2, length(place.xz)));
}
#ifdef FULL
// What lies in a direction. A light of the sliders has a radius of 10 degrees, whose sine's square is 0.03.
vec3 seen_along(vec3 from, vec3 d) {
  if (real < 0.5 && d.y < 0.0) return table_top(from - d * (from.y / d.y));
  if (room_known > 0.5) return texture(room, d * table_of_room).rgb;
  return around(d) + sun / 0.03 * smoothstep(0.983, 0.986, dot(d, to_light));
}
#endif
void main() {
  if (table > 0.5 && table < 1.5) { pixel = encoded(table_top(world)); return; }
  vec3 n = normalize(cross(dFdx(world), dFdy(world))), back = normalize(world - eye);
  if (dot(n, back) > 0.0) n = -n;
#ifdef FULL
  float shown = 1.0 - hidden(world);
  if (table > 1.5) {
    vec3 left = shade(vec3(1), n, object_passed(world) * pile_passed(world), opened(world) * under_sky(world)) / max(shade(vec3(1), n, 1.0, 1.0), 1e-4);
    pixel = vec4(0, 0, 0, shown * (1.0 - dot(left, vec3(1.0 / 3.0))));
    return;
  }
  vec3 lit = shade(albedo, n, 1.0, 1.0);
  if (metal > 0.5) {
    vec3 s = normalize(smooth_normal);
    s = dot(s, back) > 0.0 ? n : s;
    lit = mix(albedo, vec3(1), pow(1.0 + dot(s, back), 5.0)) * seen_along(world, reflect(back, s));
  }
  pixel = vec4(encoded(lit).rgb, shown);
#else
  pixel = encoded(shade(albedo, n, 1.0, 1.0));
#endif
}`;

const k_glass_vertex = `
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 model;
out vec3 world, facing;
void main() {
  world = (model * vec4(position, 1)).xyz, facing = mat3(model) * normal;
  gl_Position = projection * view * vec4(world, 1);
}`;
const k_glass_fragment = `
in vec3 world, facing;
out vec4 pixel;
void main() {
  vec3 to_eye = normalize(eye - world), n = normalize(facing);
  if (dot(n, to_eye) < 0.0) n = -n;
  float rim = 0.04 + 0.96 * pow(1.0 - dot(n, to_eye), 4.0), lamp = smoothstep(0.965, 0.985, dot(reflect(-to_eye, n), to_light));
  vec3 mirrored = around(reflect(-to_eye, n)) + 4.0 * sun * lamp;
  float covers = min(0.9 * rim, 1.0) * (1.0 - hidden(world));
  pixel = vec4(encoded(mirrored * 0.9).rgb * covers + vec3(lamp * 0.5 * (1.0 - hidden(world))), covers);
}`;

// The camera's picture, upside down, because its rows come from the lowest up.
const k_copy_vertex = `
out vec2 at;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  at = vec2(0.5, 0.5) + vec2(0.5, -0.5) * corner;
  gl_Position = vec4(corner, 0, 1);
}`;
const k_copy_fragment = `
in vec2 at;
uniform sampler2D image;
out vec4 pixel;
void main() { pixel = texture(image, at); }`;

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

// A camera that turns about a point of the table.
export class Camera {
  target = [0, 0.14, 0];
  azimuth = 0.35;
  elevation = 0.4;
  distance = 1;
  fov = 0.6;
  fit = 0.66; // the least width that is seen, of the height
  turn(right, up) {
    this.azimuth -= right;
    this.elevation = Math.min(1.5, Math.max(0.08, this.elevation + up));
  }
  zoom(factor) {
    this.distance = Math.min(3, Math.max(0.25, this.distance * factor));
  }
  axes() {
    const flat = Math.cos(this.elevation);
    const away = [Math.sin(this.azimuth) * flat, Math.sin(this.elevation), Math.cos(this.azimuth) * flat];
    const right = unit(cross([0, 1, 0], away));
    return { eye: this.target.map((x, i) => x + away[i] * this.distance), right, up: cross(away, right), away };
  }
  // Where the ray through a point of the canvas, 0..1 from its upper left corner, meets the plane y = height.
  onPlane(x, y, aspect, height = 0) {
    const { eye, right, up, away } = this.axes();
    const half = this.half(aspect);
    const ray = unit(away.map((a, i) => -a + right[i] * (2 * x - 1) * half[0] + up[i] * (1 - 2 * y) * half[1]));
    if (ray[1] > -0.02) return null;
    const along = (height - eye[1]) / ray[1];
    return eye.map((e, i) => e + along * ray[i]);
  }
  // On a tall screen the width is what must fit.
  half(aspect) {
    const half = Math.tan(this.fov / 2) * Math.max(1, this.fit / aspect);
    return [half * aspect, half];
  }
}

export class Painter {
  // `radius`: a particle's. Sand is plain until the block of grains comes.
  constructor(canvas, radius) {
    const gl = (this.gl = canvas.getContext("webgl2", { antialias: false, powerPreference: "low-power" }));
    if (!gl)
      throw new Error(
        "This browser has no WebGL 2, so nothing can be drawn. Update it, or turn hardware acceleration on.",
      );
    this.canvas = canvas;
    this.plain = program(gl, k_solid_vertex, k_solid_fragment);
    this.glassProgram = program(gl, k_kit.uniforms + k_glass_vertex, k_lighting + k_glass_fragment);
    this.glass = null;
    this.sand = new SandPainter(gl, k_kit.before + k_hidden, k_plain, radius);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.nothing = uploadShadow(gl, k_nothing);
    for (const name of k_textures) this[name] = this.nothing; // until one comes
    this.room = gl.createTexture();
    this.roomKnown = 0;
    for (let face = 0; face < 6; ++face) this.uploadFace(face, 1, new Uint16Array(4));
    this.objects = [];
    this.funnels = []; // matrices of `funnel`, an item
    const s = 3;
    this.table = this.mesh(
      new Float32Array([-s, 0, -s, -s, 0, s, s, 0, s, s, 0, -s]),
      new Uint32Array([0, 1, 2, 0, 2, 3]),
    );
    this.wall = null; // { model, on, plane }: what makes a place of its own one of the world, and back
    this.depthOnScreen = null; // where a share of the screen, from its lower left corner, lies in the depth image
    this.tableOfRoom = [1, 0, 0, 0, 1, 0, 0, 0, 1];
    gl.enable(gl.DEPTH_TEST);
    gl.flush();
  }

  // With metal, and over what is real. Compilers take as long for it as for all others: it is made when something needs it.
  get full() {
    return (this.fullProgram ??= program(this.gl, k_solid_vertex, `#define FULL\n${k_solid_fragment}`));
  }

  // What sand_block makes.
  setBlock(block) {
    for (const texture of this.sand.block) this.gl.deleteTexture(texture);
    this.sand.block = [0, 1].map((which) => this.sand.blockTexture(block, which));
  }
  // What drawn() of a stage gives.
  take(drawn) {
    this.drawn = drawn;
    this.sand.streams = drawn.streams;
    for (const [name, texture] of Object.entries(drawn.textures)) uploadShadow(this.gl, texture, this.own(name));
    if (drawn.skin) this.sand.upload(drawn.skin);
  }
  own(name) {
    if (this[name] === this.nothing) this[name] = uploadShadow(this.gl, k_nothing);
    return this[name];
  }
  // Halves, the upper row first, as the library gives them.
  uploadFace(face, side, halves) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, this.room);
    gl.texImage2D(gl.TEXTURE_CUBE_MAP_POSITIVE_X + face, 0, gl.RGBA16F, side, side, 0, gl.RGBA, gl.HALF_FLOAT, halves);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_CUBE_MAP, name, gl.LINEAR);
  }
  // Metres, the upper row first. `onScreen`: columns of the 3 x 3 matrix of depthOnScreen.
  uploadDepth(width, height, metres, onScreen) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.own("depth"));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16F, width, height, 0, gl.RED, gl.FLOAT, metres);
    this.depthOnScreen = onScreen;
  }
  // `normals`: of metal, one a vertex.
  mesh(vertices, indices, normals = null) {
    const { gl } = this;
    const made = { array: gl.createVertexArray(), count: indices.length };
    gl.bindVertexArray(made.array);
    for (const [at, values] of [vertices, normals].entries()) {
      if (!values) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return made;
  }
  item(vertices, indices, model, albedo, normals = null) {
    return { ...this.mesh(vertices, indices, normals), model, albedo, metal: normals ? 1 : 0 };
  }
  // Gives what `remove` takes.
  add(...item) {
    return this.objects[this.objects.push(this.item(...item)) - 1];
  }
  remove(object) {
    this.objects = this.objects.filter((other) => other !== object);
    this.gl.deleteVertexArray(object.array);
  }

  // What is drawn with several samples a pixel, before it is shown.
  manySamples(width, height) {
    const { gl } = this;
    const made = (this.samples ??= {
      frame: gl.createFramebuffer(),
      parts: [
        [gl.COLOR_ATTACHMENT0, gl.RGBA8],
        [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24],
      ].map((part) => [...part, gl.createRenderbuffer()]),
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, made.frame);
    if (made.width === width && made.height === height) return;
    for (const [attached, format, buffer] of made.parts) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, k_samples, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attached, gl.RENDERBUFFER, buffer);
    }
    made.width = width;
    made.height = height;
  }
  // The picture of a camera on the canvas.
  draw(camera, { pixels, smooth } = { pixels: 2, smooth: true }) {
    const { gl, canvas } = this;
    const scale = Math.min(devicePixelRatio, pixels);
    const [width, height] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const { eye, right, up, away } = camera.axes();
    const half = camera.half(width / height);
    const near = 0.05;
    const far = 12;
    const view = new Float32Array([
      right[0],
      up[0],
      away[0],
      0,
      right[1],
      up[1],
      away[1],
      0,
      right[2],
      up[2],
      away[2],
      0,
      -dot(right, eye),
      -dot(up, eye),
      -dot(away, eye),
      1,
    ]);
    const projection = new Float32Array([
      1 / half[0],
      0,
      0,
      0,
      0,
      1 / half[1],
      0,
      0,
      0,
      0,
      (far + near) / (near - far),
      -1,
      0,
      0,
      (2 * far * near) / (near - far),
      0,
    ]);
    if (smooth) this.manySamples(width, height);
    else gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.clearColor(0.807, 0.796, 0.772, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.paint({ view, projection, eye, viewport: [0, 0, width, height], real: false });
    if (!smooth) return;
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.invalidateFramebuffer(gl.READ_FRAMEBUFFER, [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  // A texture of the camera's in few pixels: RGBA bytes, the upper row first.
  shrink(texture, width, height) {
    const { gl } = this;
    if (!this.small) {
      this.small = {
        copy: program(gl, k_copy_vertex, k_copy_fragment),
        frame: gl.createFramebuffer(),
        texture: uploadShadow(gl, k_nothing),
      };
    }
    if (this.small.height !== height) {
      this.small.height = height;
      gl.bindTexture(gl.TEXTURE_2D, this.small.texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    }
    const { copy, frame, texture: target } = this.small;
    const bytes = new Uint8Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    gl.viewport(0, 0, width, height);
    gl.useProgram(copy.made);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(copy.at("image"), 0);
    gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  }

  // One view of the table. `real`: table and wall are those that a camera shows, and get shadows alone.
  paint({ view, projection, eye, viewport, real }) {
    const { gl, wall, drawn } = this;
    const all = [...this.objects, ...this.funnels.map((model) => ({ ...this.funnel, model }))];
    const solid = real || all.some(({ metal }) => metal) ? this.full : this.plain;
    const still = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    const depth = real && this.depthOnScreen;
    const m = depth || Array(9).fill(0);
    const [left, low, width, height] = viewport;
    const depthFromScreen = m.map((x, i) =>
      i < 3 ? x / width : i < 6 ? x / height : x - (m[i - 6] * left) / width - (m[i - 3] * low) / height,
    );
    gl.viewport(...viewport);
    const common = (p, pile, sky) => {
      gl.useProgram(p.made);
      [pile, this.shadow, this.occlusion, sky, depth ? this.depth : this.nothing].forEach((texture, unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
      });
      ["pile", "shadow", "occlusion", "sky", "real_depth", "room"].forEach((name, unit) =>
        gl.uniform1i(p.at(name), unit),
      );
      gl.activeTexture(gl.TEXTURE5);
      gl.bindTexture(gl.TEXTURE_CUBE_MAP, this.room);
      gl.activeTexture(gl.TEXTURE0);
      setUniforms(gl, p, {
        ...kitValues(drawn),
        view,
        projection,
        eye,
        table_of_room: this.tableOfRoom,
        wall: real && wall ? wall.plane : [0, 0, 0, 1e9],
        bias: k_depth_bias,
        depth_from_screen: depthFromScreen,
      });
    };
    const drawItem = ({ array, count: corners, model, albedo = [0, 0, 0], table = 0, metal = 0 }) => {
      gl.uniformMatrix4fv(solid.at("model"), false, model);
      gl.uniform3fv(solid.at("albedo"), albedo);
      gl.uniform1f(solid.at("table"), table);
      gl.uniform1f(solid.at("metal"), metal);
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, corners, gl.UNSIGNED_INT, 0);
    };
    common(solid, this.pile, this.sky);
    gl.uniform1f(solid.at("real"), real ? 1 : 0);
    gl.uniform1f(solid.at("room_known"), this.roomKnown);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    if (real) {
      gl.enable(gl.BLEND);
      gl.depthMask(false);
    } // what shows the real hides nothing
    drawItem({ ...this.table, model: still, table: real ? 2 : 1 });
    gl.depthMask(true);
    for (const item of all) drawItem(item);
    if (real && wall) this.paintWall(solid, drawItem);
    gl.bindVertexArray(null);
    const onSand = (p) => {
      common(p, this.onSand, this.skyOnSand);
      // Shadows on the table say nothing of sand that stands over wood, or over other sand.
      if (this.glass) setUniforms(gl, p, { shadow_opacity: 0, pile_opacity: 0, sky_known: 0 });
    };
    this.sand.draw(onSand, view, projection, height);
    if (this.glass) this.paintGlass(common);
    gl.disable(gl.BLEND);
  }

  // Glass is what it mirrors, most at its rim. It is drawn over all that it holds.
  paintGlass(common) {
    const { gl, glass, glassProgram: p } = this;
    common(p, this.pile, this.sky);
    gl.uniformMatrix4fv(p.at("model"), false, glass.model);
    gl.enable(gl.BLEND);
    gl.enable(gl.CULL_FACE);
    gl.depthMask(false);
    gl.blendFuncSeparate(gl.ONE, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(glass.array);
    for (const side of [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      gl.drawElements(gl.TRIANGLES, glass.count, gl.UNSIGNED_INT, 0);
    }
    gl.bindVertexArray(null);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  // The objects' shadows on a wall; sand throws none there.
  paintWall(solid, drawItem) {
    const {
      gl,
      wall,
      drawn: { boxes, shadowOpacity },
    } = this;
    if (!boxes.wallShadow || !boxes.wallOcclusion) return;
    [this.wallShadow, this.wallOcclusion].forEach((texture, i) => {
      gl.activeTexture(gl.TEXTURE1 + i);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    gl.activeTexture(gl.TEXTURE0);
    setUniforms(gl, solid, {
      on_plane: wall.on,
      shadow_box: boxes.wallShadow,
      occlusion_box: boxes.wallOcclusion,
      shadow_opacity: shadowOpacity,
      shadow_layers: [1, 0, 0],
      pile_opacity: 0,
      sky_known: 0,
    });
    gl.depthMask(false);
    drawItem({ ...this.table, model: wall.model, table: 2 });
    gl.depthMask(true);
  }
}
