// One frame of each of three scenes, recorded, and its picture by the kit alone; and a stage that gives that frame to any engine.
import { Stage } from "sandglass/stage";
import { constants } from "/renderers/sandglass/sandglass.mjs";
import { made } from "/renderers/sandglass/mesh_field.mjs";
import { SandPainter, program, setUniforms, uploadShadow } from "/renderers/sandglass/sand_painter.mjs";
import { pixelsOf } from "/renderers/sandglass/place_light.mjs";
import { SandScene } from "/renderers/sandglass/scene.mjs";
import { hourglassMade, k_neck } from "/renderers/sandglass/hourglass.mjs";
import { kitValues } from "sandglass/glsl";
import { blockMade } from "/renderers/sandglass/worker.mjs";
import { k_block_text } from "/renderers/sandglass/block_module.mjs";

export const side = 256;
export const clear = [0.1, 0.2, 0.3]; // of the kit's picture
const k_frames = 70;
const k_step = 1 / 60;
const k_upright = [0, 0, 0, 1];

// ---- What stands in them

function joined(parts) {
  const [positions, indices] = [[], []];
  for (const { attributes, index } of parts) {
    const first = positions.length / 3;
    positions.push(...attributes.position.array);
    indices.push(...Array.from(index.array, (i) => i + first));
  }
  return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}
function chair({ BoxGeometry }) {
  const box = (size, at) => new BoxGeometry(...size).translate(...at);
  const legs = [-0.07, 0.07].flatMap((x) => [-0.07, 0.07].map((z) => box([0.016, 0.1, 0.016], [x, 0.05, z])));
  return joined([...legs, box([0.17, 0.016, 0.17], [0, 0.108, 0]), box([0.17, 0.12, 0.016], [0, 0.17, -0.077])]);
}
const knot = ({ TorusKnotGeometry }) => joined([new TorusKnotGeometry(0.06, 0.018, 128, 16).translate(0, 0.09, 0)]);

// ---- How they are made. Each gives its radius and what goes on in a frame.

// A sky that is light above, and its main light: whatever the room's is, here it is strong.
function underASky(stage) {
  const [width, height] = [64, 48];
  const data = Uint8ClampedArray.from({ length: 4 * width * height }, (_, i) =>
    i < 40 * width ? 250 : 90 + 10 * (i % 4),
  );
  stage.see({ data, width, height }, { position: [0, 1, 1], orientation: [-0.3, 0, 0, 0.954], diagonal: 70, ms: 0 });
}
const k_strong = { facing: [2.4, 2.2, 1.9] };
// As the README's camera took it.
async function inAPhotograph(stage) {
  const image = await createImageBitmap(await (await fetch("/renderers/room.jpg")).blob());
  const up = Math.tan((28 * Math.PI) / 180);
  const diagonal = (360 / Math.PI) * Math.atan(Math.hypot(up, (up * image.width) / image.height));
  const orientation = [Math.sin(-0.085), 0, 0, Math.cos(0.085)];
  stage.see(pixelsOf(image), { position: [0, 1.1, 1.9], orientation, diagonal, ms: 0 });
}
async function poured(stage, mesh, position) {
  const { radius } = await stage.createSand({ particles: 2000 });
  stage.addModel({ ...mesh, position: [0, 0, 0], rotation: k_upright });
  await stage.fields;
  stage.pour({ position });
  return { radius, step: () => stage.frame(k_step) };
}
const hourglassParts = async () => hourglassMade(await (await fetch("/renderers/hourglass.bin")).arrayBuffer());
// It was just turned over: all sand is above.
async function hourglass(stage, mesh) {
  const { sand } = stage;
  const radius = 0.0035;
  const [, stands] = k_neck.position;
  const { field, below } = await hourglassParts();
  const friction = { static_friction: 0.3, kinetic_friction: 0.3 };
  const granular = { particle_radius: radius, particle_capacity: 1200, collider_capacity: 2, ...friction };
  const still = { rotation: k_upright, size: [1, 1, 1] };
  const glass = {
    shape: constants.SANDGLASS_SHAPE_FIELD,
    ...still,
    position: k_neck.position,
    field: { made: field },
  };
  const particles = below.slice(0, 3 * 1200).map((x, i) => (i % 3 === 1 ? 2 * stands - x : x));
  const colliders = [{ shape: constants.SANDGLASS_SHAPE_HALF_SPACE, ...still, position: [0, 0, 0], field: 0 }, glass];
  const file = { gravity: [0, -9.81, 0], frame_step: k_step, emitters: [], particles, granular, colliders };
  const scene = new SandScene(sand, file, { clock: true });
  scene.input.skin = made(sand, "sandglass_skin", { capped: 1 }, scene.desc.granular);
  stage.showSand(scene.input.skin, radius);
  stage.pour(k_neck); // the stream below it
  stage.castOnly(stage.addModel({ ...mesh, position: [0, 0, 0], rotation: k_upright }, { collide: false }));
  const step = () => {
    const light = stage.fade(k_step);
    stage.shade(light.toLight, [...stage.fadedLight.ambient_cells], stage.fadedLight.main_angular_diameter);
    scene.input.set(stage.frameFields);
    scene.frame();
    return stage.drawn(light);
  };
  return { radius, step };
}
async function wood() {
  const { vertices, indices } = (await hourglassParts()).wood;
  return { positions: vertices.map((x, i) => x + (i % 3 === 1 ? k_neck.position[1] : 0)), indices };
}
export const scenes = {
  "pour onto a chair": {
    eye: [0.2, 0.3, 0.5],
    target: [0, 0.09, 0],
    mesh: chair,
    see: underASky,
    make: (stage, mesh) => poured(stage, mesh, [0.02, 0.4, 0.02]),
    light: k_strong,
  },
  "a model in a photograph": {
    eye: [0.1, 0.35, 0.45],
    target: [0, 0.05, 0],
    mesh: knot,
    see: inAPhotograph,
    make: (stage, mesh) => poured(stage, mesh, [0, 0.4, 0]),
  },
  hourglass: {
    eye: [0.1, 0.2, 0.4],
    target: [0, 0.12, 0],
    mesh: wood,
    see: inAPhotograph,
    make: hourglass,
  },
};
export const [first] = Object.keys(scenes);

const recordings = {};
export const recorded = (name = first) => (recordings[name] ??= record(scenes[name]));
async function record({ mesh: shape, see, make, light }) {
  const stage = await Stage.create({ budget: 1000 });
  const mesh = await shape(await import("three"));
  await see(stage);
  const { radius, step } = await make(stage, mesh);
  const textures = {};
  const chunks = new Map();
  let drawn;
  let skin;
  for (let i = 0; i < k_frames; ++i) {
    drawn = step();
    for (const [name, { side, bytes }] of Object.entries(drawn.textures))
      textures[name] = { side, bytes: bytes.slice() };
    for (const { number, vertices, indices } of drawn.skin?.chunks ?? [])
      chunks.set(number, { number, vertices: vertices.slice(), indices: indices.slice() });
    if (drawn.skin) skin = { ...drawn.skin, loose: drawn.skin.loose.slice() };
  }
  const rest = structuredClone({ ...drawn, skin: null, textures: {} });
  return {
    ...rest,
    light: { ...rest.light, ...light },
    pileOpacity: 0.9,
    shadowOpacity: 0.9,
    radius,
    textures,
    mesh,
    skin: { ...skin, chunks: [...chunks.values()] },
  };
}

// In place of an engine's stage.
export const replay = (drawn) => ({
  frame: () => drawn,
  createSand: () => ({ radius: drawn.radius }),
  fields: Promise.resolve(),
  addPlace: () => 1,
  pour() {},
  push() {},
  end() {},
});

// The mesh of a scene as it hides sand: only its depth is drawn.
function depthOnly(gl, { positions, indices }, view, projection) {
  const { made: used, at } = program(
    gl,
    "layout(location = 0) in vec3 place; uniform mat4 view, projection; void main() { gl_Position = projection * view * vec4(place, 1); }",
    "out vec4 colour; void main() { colour = vec4(0); }",
  );
  gl.useProgram(used);
  gl.uniformMatrix4fv(at("view"), false, view);
  gl.uniformMatrix4fv(at("projection"), false, projection);
  for (const [kind, data] of [
    [gl.ARRAY_BUFFER, positions],
    [gl.ELEMENT_ARRAY_BUFFER, indices],
  ]) {
    gl.bindBuffer(kind, gl.createBuffer());
    gl.bufferData(kind, data, gl.STATIC_DRAW);
  }
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  gl.colorMask(false, false, false, false);
  gl.drawElements(gl.TRIANGLES, indices.length, gl.UNSIGNED_INT, 0);
  gl.colorMask(true, true, true, true);
}
// The least milliseconds of some pictures, which are read.
const k_pictures = 2;
export async function least(look) {
  let [bytes, ms] = [null, Infinity];
  for (let i = 0; i < k_pictures; ++i) {
    const from = performance.now();
    bytes = await look();
    ms = Math.min(ms, performance.now() - from);
  }
  return { bytes, ms };
}
// The picture, the lowest row first. `turned`: drawn upside down and turned back, as WebGPU puts rows.
export async function ofKit(name, camera, turned) {
  const drawn = await recorded(name);
  const { eye } = scenes[name];
  const gl = new OffscreenCanvas(side, side).getContext("webgl2", { antialias: false });
  const block = await blockMade(Uint8Array.from(atob(k_block_text), (letter) => letter.charCodeAt(0)));
  const painter = new SandPainter(gl, "float hidden(vec3 world) { return 0.0; }\n", block, drawn.radius);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  painter.upload(drawn.skin);
  painter.streams = drawn.streams;
  const names = { pile: "onSand", shadow: "shadow", occlusion: "occlusion", sky: "skyOnSand" };
  const empty = (name) => ({ side: 1, bytes: Uint8Array.of(name === "occlusion" || name === "sky" ? 255 : 0) });
  const shown = Object.entries(names).map(([name, of]) => [name, uploadShadow(gl, drawn.textures[of] ?? empty(name))]);
  const view = camera.matrixWorldInverse.elements;
  const projection = camera.projectionMatrix.elements.map((x, i) => (turned && i % 4 === 1 ? -x : x));
  const common = (program) => {
    gl.useProgram(program.made);
    shown.forEach(([name, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(program.at(name), unit);
    });
    setUniforms(gl, program, { ...kitValues(drawn), view, projection, eye });
  };
  let calls;
  for (const call of ["drawElements", "drawElementsInstanced"]) {
    const own = gl[call];
    gl[call] = (...how) => {
      ++calls;
      own.apply(gl, how);
    };
  }
  gl.clearColor(...clear, 1);
  gl.enable(gl.DEPTH_TEST);
  gl.viewport(0, 0, side, side);
  const { bytes, ms } = await least(() => {
    calls = 0;
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    depthOnly(gl, drawn.mesh, view, projection);
    painter.draw(common, view, projection, side);
    const bytes = new Uint8Array(4 * side * side);
    gl.readPixels(0, 0, side, side, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  });
  gl.getExtension("WEBGL_lose_context").loseContext();
  return { bytes: turned ? flipped(bytes) : bytes, ms, calls };
}

export function flipped(bytes) {
  const rows = new Uint8Array(bytes.length);
  for (let y = 0; y < side; ++y)
    rows.set(bytes.subarray(4 * side * (side - 1 - y), 4 * side * (side - y)), 4 * side * y);
  return rows;
}

// Of pixels that are sand in either picture: how many; the mean difference; the share that differs by more than 4 of 255.
export function difference(one, other) {
  const isSand = (bytes, i) => [0, 1, 2].some((k) => Math.abs(bytes[i + k] - bytes[k]) > 1); // a corner is background
  let [sand, over, sum] = [0, 0, 0];
  for (let i = 0; i < one.length; i += 4) {
    const [a, b] = [isSand(one, i), isSand(other, i)];
    if (!a && !b) continue;
    ++sand;
    const apart = [0, 1, 2].map((k) => Math.abs(one[i + k] - other[i + k]));
    if (a !== b || Math.max(...apart) > 4) ++over;
    if (a && b) sum += apart.reduce((all, x) => all + x) / 3;
  }
  return { sand, mean: sum / sand, over: over / sand };
}

// Presenting a canvas of WebGPU loses the device of a browser without a GPU: a texture of our own takes the canvas' place.
const held = globalThis.GPUCanvasContext?.prototype;
if (held) {
  held.configure = function (how) {
    Object.assign(this, { how, own: null });
  };
  held.unconfigure = () => {};
  held.getConfiguration = function () {
    return this.how;
  };
  held.getCurrentTexture = function () {
    const { device, format, viewFormats = [] } = this.how;
    const { width, height } = this.canvas;
    if (this.own?.width !== width || this.own?.height !== height)
      this.own = device.createTexture({ size: [width, height], format, viewFormats, usage: 0x15 });
    return this.own;
  };
}
// What an engine drew on a canvas, the lowest row first; of a larger one the middle.
export async function shown(canvas) {
  const bytes = new Uint8Array(4 * side * side);
  const gpu = canvas.getContext("webgpu");
  if (!gpu) {
    const gl = canvas.getContext("webgl2");
    gl.readPixels(0, 0, side, side, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return bytes;
  }
  const { own, how } = gpu;
  const buffer = how.device.createBuffer({ size: 4 * side * side, usage: 9 });
  const encoder = how.device.createCommandEncoder();
  const origin = [(canvas.width - side) >> 1, (canvas.height - side) >> 1];
  encoder.copyTextureToBuffer({ texture: own, origin }, { buffer, bytesPerRow: 4 * side }, [side, side]);
  how.device.queue.submit([encoder.finish()]);
  await buffer.mapAsync(1);
  bytes.set(new Uint8Array(buffer.getMappedRange()));
  if (how.format.startsWith("bgra"))
    for (let i = 0; i < bytes.length; i += 4) [bytes[i], bytes[i + 2]] = [bytes[i + 2], bytes[i]];
  return flipped(bytes);
}
// Pictures side by side, as an address of a PNG.
export function pictured(...pictures) {
  const canvas = Object.assign(newCanvas(), { width: side * pictures.length });
  const context = canvas.getContext("2d");
  pictures.forEach((bytes, i) =>
    context.putImageData(
      new ImageData(
        new Uint8ClampedArray(flipped(bytes)).map((x, k) => (k % 4 === 3 ? 255 : x)),
        side,
      ),
      side * i,
      0,
    ),
  );
  return canvas.toDataURL();
}
export const newCanvas = () => Object.assign(document.createElement("canvas"), { width: side, height: side });
