// Draws the table, the object and the sand with WebGL 2. Colours are linear until a shader's last line. Grains are
// point sprites, whose fragments write the depth of a sphere; the buffer of grains is uploaded as the library wrote it.
// Grains differ in size, shade and faces by their numbers. Shadows are the library's own textures: of the sharp main
// light, and of the light from all around, which object and sand keep from the table, and the sand from itself. Over a
// camera's image table and wall get shadows alone, and what is real hides what is drawn behind it
// (runtime/shadow/README.md). Metal reflects the room's cube, or the sliders' sky, and the table.

const k_depth_bias = 0.02;  // metres

const k_lighting = `
uniform vec3 eye;
uniform vec3 to_light, sun, ambient[9];  // irradiance over pi, of a surface that faces the sun, and by the normal
uniform vec3 below;                      // the radiance of the floor, which ambient holds
uniform mat3 table_of_room;              // ambient is of the room, all else of the table
vec3 around(vec3 normal) {
  vec3 n = normal * table_of_room;
  return max(ambient[0] + ambient[1] * n.y + ambient[2] * n.z + ambient[3] * n.x + ambient[4] * n.x * n.y + ambient[5] * n.y * n.z +
    ambient[6] * (3.0 * n.z * n.z - 1.0) + ambient[7] * n.x * n.z + ambient[8] * (n.x * n.x - n.y * n.y), 0.0);
}
vec3 shade(vec3 albedo, vec3 normal, float direct, float open) {
  return albedo * (sun * max(dot(normal, to_light), 0.0) * direct + around(normal) * open);
}
// Sand lies on sand: what it does not see of the room is as bright as it is.
vec3 shade_sand(vec3 albedo, vec3 normal, float direct, float open) {
  vec3 rest = max(around(normal) - below * (0.5 - 0.5 * (normal * table_of_room).y), 0.0) * open / (1.0 - albedo * (1.0 - open));
  return albedo * (sun * max(dot(normal, to_light), 0.0) * direct + rest);
}
vec4 encoded(vec3 linear) {
  linear = clamp(linear, 0.0, 1.0);
  return vec4(mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear)), 1);
}
// What the sand hides of the table, or of itself; what the object leaves of the room; what the sand leaves of it.
uniform sampler2D pile, object, seen, sky;
uniform vec4 pile_box, object_box, seen_box;  // x and z of the lower corner, and one over the extent
uniform mat4 on_plane;                        // of a place on the plane that is drawn: x, height and z; the table's is the world
uniform float pile_opacity, object_opacity, sky_known;
float passed(sampler2D image, vec2 at, float opacity) {
  bool on = all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? 1.0 - texture(image, at).r * opacity : 1.0;
}
float opened(vec3 place) {
  vec2 at = ((on_plane * vec4(place, 1)).xz - seen_box.xy) * seen_box.zw;
  bool on = all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? texture(seen, at).r : 1.0;
}
float under_sky(vec3 place) {
  vec2 at = (place.xz - pile_box.xy) * pile_box.zw;
  bool on = sky_known > 0.5 && all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)));
  return on ? texture(sky, at).r : 1.0;
}
// The ray from the light through the place goes on to the plane, where the object's shadow was made.
float shadowed(vec3 place, float onto) {
  vec3 p = (on_plane * vec4(place, 1)).xyz, l = mat3(on_plane) * to_light;
  vec2 at = p.xz - l.xz * (p.y / max(l.y, 0.05)) * onto;
  float share = passed(object, (at - object_box.xy) * object_box.zw, object_opacity);
  return share * passed(pile, (place.xz - pile_box.xy) * pile_box.zw, pile_opacity);
}
uniform sampler2D real_depth;    // of the camera, metres along its axis; 0: not known
uniform mat3 depth_from_screen;  // where a pixel lies in it
uniform vec4 wall;               // a place's distance from it
uniform float bias;              // metres that the depth may be wrong by
// How much something real hides of what is drawn. What the camera shows on table or wall is table or wall.
float hidden(vec3 place) {
  ivec2 size = textureSize(real_depth, 0);
  vec2 at = (depth_from_screen * vec3(gl_FragCoord.xy, 1)).xy * vec2(size) - 0.5, part = fract(at);
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 corner = ivec2(i & 1, i >> 1);
    float real = texelFetch(real_depth, clamp(ivec2(floor(at)) + corner, ivec2(0), size - 1), 0).r, share = real * gl_FragCoord.w;
    float from_wall = mix(dot(wall, vec4(eye, 1)), dot(wall, vec4(place, 1)), share);
    float before = min((1.0 - share) / gl_FragCoord.w, min(mix(eye.y, place.y, share), from_wall));
    vec2 weight = mix(1.0 - part, part, vec2(corner));
    sum += weight.x * weight.y * (real > 0.0 ? smoothstep(bias, 2.0 * bias, before) : 0.0);
  }
  return sum;
}`;

const k_grain_vertex = `
layout(location = 0) in vec4 grain;
uniform mat4 view, projection;
uniform float radius, pixels;
flat out vec3 centre, colour;
flat out vec4 faces[7];  // where to, and the cosine of its rim
flat out float size;
// A grain's colour, size and faces are those of models/drawing/render.cpp, by the same hash: so it looks in films, too.
uint hashed(uint v) {
  v = (v ^ (v >> 16u)) * 0x7feb352du;
  v = (v ^ (v >> 15u)) * 0x846ca68bu;
  return v ^ (v >> 16u);
}
float drawn(inout uint state) {
  state = hashed(state + 0x9e3779b9u);
  return float(state >> 8u) / 16777216.0;
}
void main() {
  gl_Position = vec4(2, 2, 2, 1);
  if (grain.w < 0.0) return;
  vec4 at = view * vec4(grain.xyz, 1);
  centre = at.xyz;
  uint number = uint(gl_VertexID) * 2u + 1u, sized = number + 0x51ed270bu, broken_off = number + 0x2545f491u;
  size = radius * mix(0.75, 1.2, drawn(sized));
  for (int k = 0; k < 7; ++k) {
    float height = 2.0 * drawn(broken_off) - 1.0, turn = 6.2831853 * drawn(broken_off), across = sqrt(1.0 - height * height);
    faces[k] = vec4(across * cos(turn), height, across * sin(turn), 0.75 + 0.2 * drawn(broken_off));
  }
  gl_Position = projection * at;
  gl_PointSize = max(2.0 * size * pixels / -at.z, 1.0);
  float light = 2.0 * drawn(number) - 1.0, warm = 2.0 * drawn(number) - 1.0;
  colour = vec3(0.60, 0.40, 0.20) * (1.0 + 0.28 * light) * vec3(1.0 + 0.1 * warm, 1.0, 1.0 - 0.1 * warm);
}`;
const k_grain_fragment = `
flat in vec3 centre, colour;
flat in vec4 faces[7];
flat in float size;
uniform mat4 view, projection;
uniform sampler2D heights;    // of the sand's surface
uniform float most_height, radius;  // what 255 stands for; the mean of the grains
out vec4 pixel;
// The face that is broken off the grain there, if one is; its rim is round.
vec3 broken(vec3 n) {
  vec3 face = n;
  float nearest = 0.0;
  for (int k = 0; k < 7; ++k) {
    float above = dot(n, faces[k].xyz) - faces[k].w;
    if (above > nearest) nearest = above, face = faces[k].xyz;
  }
  return normalize(mix(n, face, 0.7));
}
${k_lighting}
void main() {
  vec2 at = gl_PointCoord * vec2(2, -2) + vec2(-1, 1);
  float gap = 1.0 - dot(at, at);
  if (gap < 0.0) discard;
  vec3 normal = vec3(at, sqrt(gap)), place = centre + size * normal;
  vec4 clip = projection * vec4(place, 1);
  gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
  mat3 back = transpose(mat3(view));
  vec3 world = back * (place - view[3].xyz), n = broken(back * normal);
  // Deeper under the surface there is less.
  float deep = clamp((most_height * texture(heights, (world.xz - pile_box.xy) * pile_box.zw).r - world.y) / radius, 0.0, 1.5);
  float open = sky_known > 0.5 ? under_sky(world) / (1.0 + 0.9 * deep) : 0.75;
  pixel = vec4(encoded(shade_sand(colour, n, shadowed(world, 1.0), open)).rgb, 1.0 - hidden(world));
}`;
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
const vec3 k_wood = vec3(0.42, 0.36, 0.30), k_around = vec3(0.055, 0.06, 0.07);
vec3 table_top(vec3 place) {
  float grain = sin(place.x * 90.0 + 3.0 * sin(place.z * 7.0)) * 0.5 + sin(place.x * 23.0 + 2.0 * sin(place.z * 3.0 + 1.0));
  vec3 lit = shade(k_wood * (1.0 + 0.05 * grain), vec3(0, 1, 0), shadowed(place, 0.0), opened(place) * under_sky(place));
  return mix(lit, k_around, smoothstep(0.55, 1.5, length(place.xz)));
}
// What lies in a direction. A light of the sliders has a radius of 10 degrees, whose sine's square is 0.03.
vec3 seen_along(vec3 from, vec3 d) {
  if (real < 0.5 && d.y < 0.0) return table_top(from - d * (from.y / d.y));
  if (room_known > 0.5) return texture(room, d * table_of_room).rgb;
  return around(d) + sun / 0.03 * smoothstep(0.983, 0.986, dot(d, to_light));
}
void main() {
  if (table > 0.5 && table < 1.5) { pixel = encoded(table_top(world)); return; }
  vec3 n = normalize(cross(dFdx(world), dFdy(world))), back = normalize(world - eye);
  if (dot(n, back) > 0.0) n = -n;
  float shown = 1.0 - hidden(world);
  if (table > 1.5) {
    vec3 left = shade(vec3(1), n, shadowed(world, 0.0), opened(world) * under_sky(world)) / max(shade(vec3(1), n, 1.0, 1.0), 1e-4);
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

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, body] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, `#version 300 es\nprecision highp float;\nprecision highp int;\n${body}`);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`This browser refuses a shader: ${gl.getShaderInfoLog(shader)}`);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(`This browser refuses a program: ${gl.getProgramInfoLog(made)}`);
  const at = new Map();
  return { made, at: (name) => at.get(name) ?? (at.set(name, gl.getUniformLocation(made, name)), at.get(name)) };
}

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

// A camera that turns about a point of the table.
export class Camera {
  target = [0, 0.14, 0];
  azimuth = 0.35;
  elevation = 0.5;
  distance = 1.35;
  fov = 0.6;
  turn(right, up) { this.azimuth -= right, this.elevation = Math.min(1.5, Math.max(0.08, this.elevation + up)); }
  zoom(factor) { this.distance = Math.min(3, Math.max(0.4, this.distance * factor)); }
  axes() {
    const flat = Math.cos(this.elevation);
    const away = [Math.sin(this.azimuth) * flat, Math.sin(this.elevation), Math.cos(this.azimuth) * flat];
    const right = unit(cross([0, 1, 0], away));
    return { eye: this.target.map((x, i) => x + away[i] * this.distance), right, up: cross(away, right), away };
  }
  // Where the ray through a point of the canvas, 0..1 from its upper left corner, meets the plane y = height.
  onPlane(x, y, aspect, height = 0) {
    const { eye, right, up, away } = this.axes(), half = this.half(aspect);
    const ray = unit(away.map((a, i) => -a + right[i] * (2 * x - 1) * half[0] + up[i] * (1 - 2 * y) * half[1]));
    if (ray[1] > -0.02) return null;
    const along = (height - eye[1]) / ray[1];
    return eye.map((e, i) => e + along * ray[i]);
  }
  // On a tall screen the width is what must fit.
  half(aspect) {
    const half = Math.tan(this.fov / 2) * Math.max(1, 0.8 / aspect);
    return [half * aspect, half];
  }
}

export class Painter {
  constructor(canvas) {
    const gl = this.gl = canvas.getContext("webgl2", { antialias: false, powerPreference: "low-power" });
    if (!gl) throw new Error("This browser has no WebGL 2, so nothing can be drawn. Update it, or turn hardware acceleration on.");
    this.canvas = canvas;
    this.grains = program(gl, k_grain_vertex, k_grain_fragment), this.solid = program(gl, k_solid_vertex, k_solid_fragment);
    this.grainBuffer = gl.createBuffer(), this.grainBytes = 0;
    this.pile = this.texture(), this.onSand = this.texture(), this.object = this.texture(), this.seen = this.texture();
    this.sky = this.texture(), this.skyOnSand = this.texture(), this.heights = this.texture();
    this.wallObject = this.texture(), this.wallSeen = this.texture(), this.depth = this.texture(), this.unknownDepth = this.texture();
    this.room = gl.createTexture(), this.roomKnown = 0;
    for (let face = 0; face < 6; ++face) this.uploadFace(face, 1, new Uint16Array(4));
    this.objects = [];
    const s = 3;
    this.table = this.mesh(new Float32Array([-s, 0, -s, -s, 0, s, s, 0, s, s, 0, -s]), new Uint32Array([0, 1, 2, 0, 2, 3]));
    this.objectShadow = { box: [0, 0, 1, 1], opacity: 0 };
    this.pileShadow = { box: [0, 0, 1, 1], opacity: 0, sky: 0, height: 0 };
    this.seenBox = [2, 2, 0, 0];  // nowhere
    this.wall = null;        // { model, on, plane, box, seenBox, opacity }: what makes a place of its own one of the world, and back
    this.depthOnScreen = null;  // where a share of the screen, from its lower left corner, lies in the depth image
    this.light = { sun: [0, 0, 0], ambient: new Float32Array(27), floor: [0, 0, 0] }, this.tableOfRoom = [1, 0, 0, 0, 1, 0, 0, 0, 1];
    gl.enable(gl.DEPTH_TEST);
  }

  texture() {
    const { gl } = this, made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, 1, 1, 0, gl.RED, gl.UNSIGNED_BYTE, new Uint8Array(1));
    return made;
  }
  upload(texture, side, bytes) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, side, side, 0, gl.RED, gl.UNSIGNED_BYTE, bytes);
  }
  // Halves, the upper row first, as the library gives them.
  uploadFace(face, side, halves) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_CUBE_MAP, this.room);
    gl.texImage2D(gl.TEXTURE_CUBE_MAP_POSITIVE_X + face, 0, gl.RGBA16F, side, side, 0, gl.RGBA, gl.HALF_FLOAT, halves);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_CUBE_MAP, name, gl.LINEAR);
  }
  // Metres, the upper row first. `onScreen`: columns of the 3 x 3 matrix of depthOnScreen.
  uploadDepth(width, height, metres, onScreen) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.depth);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16F, width, height, 0, gl.RED, gl.FLOAT, metres);
    this.depthOnScreen = onScreen;
  }
  // `normals`: of metal, one a vertex.
  mesh(vertices, indices, normals = null) {
    const { gl } = this, made = { array: gl.createVertexArray(), count: indices.length };
    gl.bindVertexArray(made.array);
    if (normals) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, normals, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 0, 0);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
    return made;
  }
  // Gives what `remove` takes.
  add(vertices, indices, model, albedo, normals = null) {
    return this.objects[this.objects.push({ ...this.mesh(vertices, indices, normals), model, albedo, metal: normals ? 1 : 0 }) - 1];
  }
  remove(object) { this.objects = this.objects.filter((other) => other !== object), this.gl.deleteVertexArray(object.array); }

  // The picture of a camera on the canvas.
  draw(camera, grains, count, radius) {
    const { gl, canvas } = this, scale = Math.min(devicePixelRatio, 2);
    const [width, height] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
    if (canvas.width !== width || canvas.height !== height) canvas.width = width, canvas.height = height;
    const { eye, right, up, away } = camera.axes(), half = camera.half(width / height), near = 0.05, far = 12;
    const view = new Float32Array([right[0], up[0], away[0], 0, right[1], up[1], away[1], 0, right[2], up[2], away[2], 0,
      -dot(right, eye), -dot(up, eye), -dot(away, eye), 1]);
    const projection = new Float32Array([1 / half[0], 0, 0, 0, 0, 1 / half[1], 0, 0, 0, 0, (far + near) / (near - far), -1,
      0, 0, 2 * far * near / (near - far), 0]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.clearColor(0.26, 0.27, 0.29, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.uploadGrains(grains);
    this.paint({ view, projection, eye, viewport: [0, 0, width, height], real: false }, count, radius);
  }

  uploadGrains(grains) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.grainBuffer);
    if (this.grainBytes < grains.byteLength) gl.bufferData(gl.ARRAY_BUFFER, this.grainBytes = 2 * grains.byteLength, gl.STREAM_DRAW);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, grains);
  }

  // A texture of the camera's in few pixels: RGBA bytes, the upper row first.
  shrink(texture, width, height) {
    const { gl } = this;
    if (!this.small) {
      this.small = { copy: program(gl, k_copy_vertex, k_copy_fragment), frame: gl.createFramebuffer(), texture: this.texture() };
      gl.bindTexture(gl.TEXTURE_2D, this.small.texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    }
    const { copy, frame, texture: target } = this.small, bytes = new Uint8Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    gl.viewport(0, 0, width, height);
    gl.useProgram(copy.made);
    gl.activeTexture(gl.TEXTURE0), gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(copy.at("image"), 0);
    gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  }

  // One view of the table. `real`: table and wall are those that a camera shows, and get shadows alone.
  paint({ view, projection, eye, viewport, real }, count, radius) {
    const { gl, wall } = this, still = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    const depth = real && this.depthOnScreen, m = depth || Array(9).fill(0), [left, low, width, height] = viewport;
    const depthFromScreen = m.map((x, i) => (i < 3 ? x / width : i < 6 ? x / height : x - m[i - 6] * left / width - m[i - 3] * low / height));
    gl.viewport(...viewport);
    const common = (p, pile, sky) => {
      gl.useProgram(p.made);
      [pile, this.object, this.seen, sky, this.heights, depth ? this.depth : this.unknownDepth].forEach((texture, unit) => { gl.activeTexture(gl.TEXTURE0 + unit), gl.bindTexture(gl.TEXTURE_2D, texture); });
      ["pile", "object", "seen", "sky", "heights", "real_depth", "room"].forEach((name, unit) => gl.uniform1i(p.at(name), unit));
      gl.activeTexture(gl.TEXTURE6), gl.bindTexture(gl.TEXTURE_CUBE_MAP, this.room);
      gl.activeTexture(gl.TEXTURE0);
      gl.uniformMatrix4fv(p.at("view"), false, view), gl.uniformMatrix4fv(p.at("projection"), false, projection);
      gl.uniform3fv(p.at("to_light"), this.light.toLight), gl.uniform3fv(p.at("sun"), this.light.sun), gl.uniform3fv(p.at("eye"), eye);
      gl.uniform3fv(p.at("ambient"), this.light.ambient), gl.uniform3fv(p.at("below"), this.light.floor), gl.uniformMatrix3fv(p.at("table_of_room"), false, this.tableOfRoom);
      gl.uniform4fv(p.at("pile_box"), this.pileShadow.box), gl.uniform1f(p.at("pile_opacity"), this.pileShadow.opacity);
      gl.uniform1f(p.at("sky_known"), this.pileShadow.sky), gl.uniform1f(p.at("most_height"), this.pileShadow.height);
      gl.uniform4fv(p.at("object_box"), this.objectShadow.box), gl.uniform1f(p.at("object_opacity"), this.objectShadow.opacity);
      gl.uniform4fv(p.at("seen_box"), this.seenBox), gl.uniformMatrix4fv(p.at("on_plane"), false, still);
      gl.uniform4fv(p.at("wall"), real && wall ? wall.plane : [0, 0, 0, 1e9]), gl.uniform1f(p.at("bias"), k_depth_bias);
      gl.uniformMatrix3fv(p.at("depth_from_screen"), false, depthFromScreen);
    };
    const drawItem = ({ array, count: corners, model, albedo = [0, 0, 0], table = 0, metal = 0 }) => {
      gl.uniformMatrix4fv(this.solid.at("model"), false, model);
      gl.uniform3fv(this.solid.at("albedo"), albedo), gl.uniform1f(this.solid.at("table"), table), gl.uniform1f(this.solid.at("metal"), metal);
      gl.bindVertexArray(array);
      gl.drawElements(gl.TRIANGLES, corners, gl.UNSIGNED_INT, 0);
    };
    common(this.solid, this.pile, this.sky);
    gl.uniform1f(this.solid.at("real"), real ? 1 : 0), gl.uniform1f(this.solid.at("room_known"), this.roomKnown);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    if (real) gl.enable(gl.BLEND), gl.depthMask(false);  // what shows the real hides nothing
    drawItem({ ...this.table, model: still, table: real ? 2 : 1 });
    gl.depthMask(true);
    for (const item of this.objects) drawItem(item);
    if (real && wall) this.paintWall(drawItem);
    gl.bindVertexArray(null);
    if (count > 0) {
      common(this.grains, this.onSand, this.skyOnSand);
      gl.uniform1f(this.grains.at("radius"), radius), gl.uniform1f(this.grains.at("pixels"), 0.5 * height * projection[5]);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.grainBuffer);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 4, gl.FLOAT, false, 16, 0);
      gl.drawArrays(gl.POINTS, 0, count);
    }
    gl.disable(gl.BLEND);
  }

  // The objects' shadows on a wall; sand throws none there.
  paintWall(drawItem) {
    const { gl, wall, solid } = this;
    [this.wallObject, this.wallSeen].forEach((texture, i) => { gl.activeTexture(gl.TEXTURE1 + i), gl.bindTexture(gl.TEXTURE_2D, texture); });
    gl.activeTexture(gl.TEXTURE0);
    gl.uniformMatrix4fv(solid.at("on_plane"), false, wall.on);
    gl.uniform4fv(solid.at("object_box"), wall.box), gl.uniform4fv(solid.at("seen_box"), wall.seenBox);
    gl.uniform1f(solid.at("object_opacity"), wall.opacity), gl.uniform1f(solid.at("pile_opacity"), 0), gl.uniform1f(solid.at("sky_known"), 0);
    gl.depthMask(false);
    drawItem({ ...this.table, model: wall.model, table: 2 });
    gl.depthMask(true);
  }
}
