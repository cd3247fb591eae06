// One frame of a stage, recorded, and its picture by the kit alone; and a stage that gives that frame to any engine.
import { Stage } from "sandglass/stage";
import { SandPainter, setUniforms, uploadShadow } from "/renderers/sandglass/sand_painter.mjs";
import { kitValues } from "sandglass/glsl";
import { blockMade } from "/renderers/sandglass/worker.mjs";
import { k_block_text } from "/renderers/sandglass/block_module.mjs";

export const side = 256;
export const clear = [0.1, 0.2, 0.3]; // of the kit's picture
export const eye = [0.1, 0.3, 0.6];
export const target = [0.02, 0.06, 0];
const k_box = [
  0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6, 0, 5, 1, 0, 4, 5, 1, 6, 2, 1, 5, 6, 2, 7, 3, 2, 6, 7, 3, 4, 0, 3, 7, 4,
];

let frame;
// Sand that is poured beside a box, under a sky that is light above.
export async function recorded() {
  if (frame) return frame;
  const stage = await Stage.create({ budget: 1000 });
  const { radius } = await stage.createSand({ particles: 2000 });
  const [width, height] = [64, 48];
  const data = Uint8ClampedArray.from({ length: 4 * width * height }, (_, i) =>
    i < 40 * width ? 250 : 90 + 10 * (i % 4),
  );
  stage.see({ data, width, height }, { position: [0, 1, 1], orientation: [-0.3, 0, 0, 0.954], diagonal: 70, ms: 0 });
  const corners = [-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1, -1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1];
  const box = { positions: Float32Array.from(corners, (x) => 0.05 * x), indices: Uint32Array.from(k_box) };
  stage.addModel({ ...box, position: [0.16, 0, 0.02], rotation: [0, 0, 0, 1] });
  await stage.fields;
  stage.pour({ position: [0, 0.5, 0] });
  const textures = {};
  const chunks = new Map();
  let drawn;
  let skin;
  for (let i = 0; i < 120; ++i) {
    drawn = stage.frame(1 / 60);
    for (const [name, { side, bytes }] of Object.entries(drawn.textures))
      textures[name] = { side, bytes: bytes.slice() };
    for (const { number, vertices, indices } of drawn.skin?.chunks ?? [])
      chunks.set(number, { number, vertices: vertices.slice(), indices: indices.slice() });
    if (drawn.skin) skin = { ...drawn.skin, loose: drawn.skin.loose.slice() };
  }
  const rest = structuredClone({ ...drawn, skin: null, textures: {} });
  // Whatever the room's main light is, here it is strong.
  const light = { ...rest.light, facing: [2.4, 2.2, 1.9] };
  frame = {
    ...rest,
    light,
    pileOpacity: 0.9,
    shadowOpacity: 0.9,
    radius,
    textures,
    skin: { ...skin, chunks: [...chunks.values()] },
  };
  return frame;
}

// In place of an engine's stage.
export const replay = (drawn) => ({
  frame: () => drawn,
  createSand: () => ({ radius: drawn.radius }),
  fields: Promise.resolve(),
  pour() {},
  push() {},
  end() {},
});

// Bytes of the picture, the lowest row first. `turned`: drawn upside down and turned back, as WebGPU puts rows.
export async function ofKit(camera, turned) {
  const drawn = await recorded();
  const gl = new OffscreenCanvas(side, side).getContext("webgl2", { antialias: false });
  const block = await blockMade(Uint8Array.from(atob(k_block_text), (letter) => letter.charCodeAt(0)));
  const painter = new SandPainter(gl, "float hidden(vec3 world) { return 0.0; }\n", block, drawn.radius);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  painter.upload(drawn.skin);
  painter.streams = drawn.streams;
  const names = { pile: "onSand", shadow: "shadow", occlusion: "occlusion", sky: "skyOnSand" };
  const empty = (name) => ({ side: 1, bytes: Uint8Array.of(name === "occlusion" || name === "sky" ? 255 : 0) });
  const shown = Object.entries(names).map(([name, of]) => [name, uploadShadow(gl, drawn.textures[of] ?? empty(name))]);
  gl.clearColor(...clear, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.viewport(0, 0, side, side);
  const view = camera.matrixWorldInverse.elements;
  const projection = camera.projectionMatrix.elements.map((x, i) => (turned && i % 4 === 1 ? -x : x));
  painter.draw(
    (program) => {
      gl.useProgram(program.made);
      shown.forEach(([name, texture], unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.uniform1i(program.at(name), unit);
      });
      setUniforms(gl, program, { ...kitValues(drawn), view, projection, eye });
    },
    eye,
    0.5 * side * camera.projectionMatrix.elements[5],
  );
  const bytes = new Uint8Array(4 * side * side);
  gl.readPixels(0, 0, side, side, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  gl.getExtension("WEBGL_lose_context").loseContext();
  return turned ? flipped(bytes) : bytes;
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
// What an engine drew on a canvas, the lowest row first.
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
  encoder.copyTextureToBuffer({ texture: own }, { buffer, bytesPerRow: 4 * side }, [side, side]);
  how.device.queue.submit([encoder.finish()]);
  await buffer.mapAsync(1);
  bytes.set(new Uint8Array(buffer.getMappedRange()));
  if (how.format.startsWith("bgra"))
    for (let i = 0; i < bytes.length; i += 4) [bytes[i], bytes[i + 2]] = [bytes[i + 2], bytes[i]];
  return flipped(bytes);
}
export const newCanvas = () => Object.assign(document.createElement("canvas"), { width: side, height: side });
