// What sandglass/three and sandglass/babylon have in common: a stage here or in a worker, the objects that were added to
// it, and the sand, which is drawn by WebGL itself amid the engine's own frame.
import { Stage } from "./stage.mjs";
import { isPose, k_ended } from "./options.mjs";
import { pixelsOf } from "./place_light.mjs";
import { WorkerStage, blockMade } from "./worker.mjs";
import { SandPainter, setUniforms, uploadShadow } from "./sand_painter.mjs";
import { k_block_text } from "./block_module.mjs";
import { kit, kitValues, receivers } from "./glsl.mjs";

const k_units = { pile: 0, shadow: 1, occlusion: 2, sky: 3 };
const k_painter_units = [0, 1, 2, 3, 8, 9];
const k_hidden = "float hidden(vec3 world) { return 0.0; }\n";
const k_light = `#define LINEAR_OUTPUT\n${kit.light}`;
const k_capabilities = ["BLEND", "CULL_FACE", "DEPTH_TEST", "SCISSOR_TEST", "STENCIL_TEST", "POLYGON_OFFSET_FILL"];
const k_shape_frames = 20; // from one look at a model's parts to the next
const k_shape_tolerance = 1e-3; // metres, or of a size
const k_unpack = ["UNPACK_FLIP_Y_WEBGL", "UNPACK_PREMULTIPLY_ALPHA_WEBGL"]; // engines leave the others at 0

// Does some work and leaves WebGL as it was, so that what the engine believes of it stays true. Browsers answer at once but
// for the depth buffer's state, which uploads do not touch.
function unnoticed(gl, work, draws = false) {
  const get = (name) => gl.getParameter(gl[name]);
  const can = k_capabilities.map((name) => [gl[name], gl.isEnabled(gl[name])]);
  const stores = ["UNPACK_ALIGNMENT", ...k_unpack].map((name) => [gl[name], get(name)]);
  const active = get("ACTIVE_TEXTURE");
  const before = {
    program: get("CURRENT_PROGRAM"),
    array: get("VERTEX_ARRAY_BINDING"),
    buffer: get("ARRAY_BUFFER_BINDING"),
    ...(draws ? { mask: get("DEPTH_WRITEMASK"), order: get("DEPTH_FUNC") } : {}),
  };
  const textures = k_painter_units.map((unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    return [unit, get("TEXTURE_BINDING_2D"), get("TEXTURE_BINDING_3D")];
  });
  try {
    for (const name of k_unpack) gl.pixelStorei(gl[name], 0);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.bindVertexArray(null);
    work();
  } finally {
    for (const [unit, flat, solid] of textures) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, flat);
      gl.bindTexture(gl.TEXTURE_3D, solid);
    }
    gl.activeTexture(active);
    gl.useProgram(before.program);
    gl.bindVertexArray(before.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, before.buffer);
    if (draws) {
      gl.depthMask(before.mask);
      gl.depthFunc(before.order);
    }
    for (const [name, on] of can)
      if (on) gl.enable(name);
      else gl.disable(name);
    for (const [name, value] of stores) gl.pixelStorei(name, value);
  }
}

const nameOf = ({ name }) => (name ? `"${name}"` : "a model");

// One mesh of several: positions, the corners of triangles (null: in order), and a column-major matrix; mirrored ones turn.
export function oneMesh(parts) {
  const total = (of) => parts.reduce((sum, part) => sum + of(part), 0);
  const corners_of = ({ positions, corners }) => corners?.length ?? positions.length / 3;
  const positions = new Float32Array(total((part) => part.positions.length));
  const indices = new Uint32Array(total(corners_of));
  let end = 0;
  let last = 0;
  for (const part of parts) {
    const {
      positions: p,
      corners,
      matrix: [a, b, c, , d, e, f, , g, h, k, , x, y, z],
    } = part;
    const base = end / 3;
    const count = corners_of(part);
    for (let i = 0; i < p.length; i += 3, end += 3) {
      positions[end] = a * p[i] + d * p[i + 1] + g * p[i + 2] + x;
      positions[end + 1] = b * p[i] + e * p[i + 1] + h * p[i + 2] + y;
      positions[end + 2] = c * p[i] + f * p[i + 1] + k * p[i + 2] + z;
    }
    const own = indices.subarray(last, (last += count));
    if (corners) own.set(corners);
    else for (let i = 0; i < count; ++i) own[i] = i;
    if (base > 0) for (let i = 0; i < count; ++i) own[i] += base;
    if (a * (e * k - f * h) - d * (b * k - c * h) + g * (b * f - c * e) < 0)
      for (let i = 0; i < count; i += 3) [own[i + 1], own[i + 2]] = [own[i + 2], own[i + 1]];
  }
  return { positions, indices };
}

class Sand {
  constructor(gl, block, radius) {
    this.gl = gl;
    this.textures = {};
    unnoticed(gl, () => {
      this.painter = new SandPainter(gl, k_hidden, block, radius, k_light);
      for (const name of ["onSand", "skyOnSand", "shadow", "occlusion"])
        this.upload(name, { side: 1, bytes: new Uint8Array([name === "onSand" || name === "shadow" ? 0 : 255]) });
    });
  }
  upload(name, texture) {
    this.textures[name] = uploadShadow(this.gl, texture, this.textures[name]);
  }
  take(drawn) {
    this.values = kitValues(drawn);
    unnoticed(this.gl, () => {
      for (const name of Object.keys(this.textures)) if (drawn.textures[name]) this.upload(name, drawn.textures[name]);
      if (drawn.skin) {
        this.painter.upload(drawn.skin);
        this.filled = true;
      }
    });
    this.painter.streams = drawn.streams;
  }
  end() {
    for (const texture of Object.values(this.textures)) this.gl.deleteTexture(texture);
    this.painter.end();
    this.filled = false;
  }
  // `view` and `projection` are column-major; the view looks along -z.
  draw({ view, projection, eye, height, linear, reversed }) {
    if (!this.filled) return;
    const { gl, painter, textures } = this;
    unnoticed(
      gl,
      () => {
        gl.disable(gl.BLEND);
        gl.disable(gl.CULL_FACE);
        gl.enable(gl.DEPTH_TEST);
        gl.depthMask(true);
        gl.depthFunc(reversed ? gl.GEQUAL : gl.LEQUAL);
        const set = { ...this.values, view, projection, eye, linear_output: linear ? 1 : 0 };
        painter.draw(
          (program) => {
            gl.useProgram(program.made);
            for (const [name, texture] of [
              ["pile", textures.onSand],
              ["shadow", textures.shadow],
              ["occlusion", textures.occlusion],
              ["sky", textures.skyOnSand],
            ]) {
              gl.activeTexture(gl.TEXTURE0 + k_units[name]);
              gl.bindTexture(gl.TEXTURE_2D, texture);
              gl.uniform1i(program.at(name), k_units[name]);
            }
            setUniforms(gl, program, set);
          },
          eye,
          0.5 * height * projection[5],
        );
      },
      true,
    );
  }
}

// A subclass has meshOf(object, pose), shapeOf(object, pose), poseOf(object), isShown(object), cameraOf(camera), show(drawn)
// and leave().
export class Engine {
  static async stageOf({ worker = false, ...options }) {
    return (worker ? WorkerStage : Stage).create(options);
  }
  constructor(stage, gl) {
    Object.assign(this, { stage, gl, objects: new Map(), owed: 0, last: performance.now(), sand: null, busy: false });
    this.frames = 0;
  }
  refuseEnded() {
    if (this.ended) throw new Error(k_ended);
  }
  // What fails beside a call is said; the rest goes on.
  async say(work) {
    try {
      await work();
    } catch ({ message }) {
      if (!this.ended) console.error(message);
    }
  }

  // An object's meshes throw a shadow, and sand lies on them. They are taken at their present size and as they are seen: of
  // children those that are not hidden. The object itself may be hidden, as one that stands for a real thing. Its pose is
  // followed; once it was seen, it throws no shadow while it is hidden or out of the scene.
  async addModel(object, options) {
    this.refuseEnded();
    if (typeof object?.[this.placing] !== "function")
      throw new Error("sandglass: addModel takes an object of the scene. Of a loaded glTF pass gltf.scene.");
    if (this.objects.has(object))
      throw new Error("sandglass: addModel has this object already. Call removeModel first, or pass a clone.");
    const pose = this.poseOf(object);
    if (!isPose(pose))
      throw new Error(
        `sandglass: addModel: ${nameOf(object)} has no finite pose. Set its position, rotation and scale first.`,
      );
    const mesh = this.meshOf(object, pose);
    const model = { pose, shape: this.shapeOf(object, pose), casts: options?.shadow !== false, shadow: true };
    this.objects.set(object, model);
    try {
      model.added = (async () => this.stage.addModel({ ...mesh, ...pose }, options))();
      model.number = await model.added;
    } catch (error) {
      if (this.objects.get(object) === model) this.objects.delete(object);
      throw error;
    }
    this.say(() => this.stage.fields);
  }
  // Also of one whose addModel has not answered yet.
  async removeModel(object) {
    if (this.ended) return;
    const model = this.objects.get(object);
    if (!model) throw new Error("sandglass: removeModel takes an object that addModel was given.");
    this.objects.delete(object);
    await this.stage.remove(model.number ?? (await model.added));
  }
  // An image of the room as the camera sees it: a photograph or a video's picture, not a panorama.
  async see(image, camera, options) {
    this.refuseEnded();
    if (typeof camera?.[this.placing] !== "function")
      throw new Error("sandglass: see takes an image and the camera that took it.");
    await this.stage.see(pixelsOf(image), { ...this.cameraOf(camera), ...options });
  }

  async newSand(options) {
    this.refuseEnded();
    const block = await blockMade(Uint8Array.from(atob(k_block_text), (letter) => letter.charCodeAt(0)));
    const { radius } = await this.stage.createSand(options);
    this.refuseEnded();
    this.say(() => this.stage.fields); // where sand cannot lie on a model
    this.sand?.end();
    this.sand = new Sand(this.gl, block, radius);
  }
  pour(...nozzles) {
    this.refuseEnded();
    return this.stage.pour(...nozzles);
  }
  push(...balls) {
    this.refuseEnded();
    return this.stage.push(...balls);
  }

  // Once a frame, before it is rendered. `seconds` go by; without it, as many as since the last call. A stage in a worker
  // shows each frame when it is done.
  update(seconds = (performance.now() - this.last) / 1000) {
    if (this.ended) return;
    if (!(seconds >= 0)) throw new Error("sandglass: update takes the seconds since the last frame.");
    this.last = performance.now();
    this.owed += seconds;
    if (this.busy) return;
    ++this.frames;
    for (const [object, model] of this.objects) if (model.number !== undefined) this.follow(object, model);
    const drawn = this.stage.frame(Math.min(this.owed, 0.1));
    this.owed = 0;
    if (!(drawn instanceof Promise)) return this.take(drawn);
    this.busy = true;
    drawn
      .then((arrived) => this.ended || this.take(arrived))
      .catch((error) => {
        if (!this.ended) throw error;
      })
      .finally(() => {
        this.busy = false;
      });
  }
  // A model in this frame. Without a pose, as where a tracker has lost it, it stays where it was.
  follow(object, model) {
    const pose = this.poseOf(object);
    const shown = this.isShown(object);
    model.seen ||= shown;
    const shadow = shown || !model.seen;
    if (model.casts && shadow !== model.shadow) {
      model.shadow = shadow;
      this.say(() => this.stage.setShadow(model.number, shadow));
    }
    if (!isPose(pose)) return;
    if (String([pose.position, pose.rotation]) !== String([model.pose.position, model.pose.rotation])) {
      model.pose = pose;
      this.say(() => this.stage.move(model.number, pose.position, pose.rotation));
    }
    if (!this.warned && this.frames % k_shape_frames === 0) this.warnOfShape(object, model);
  }
  warnOfShape(object, { pose, shape }) {
    const now = this.shapeOf(object, pose);
    if (now.length === shape.length && now.every((x, i) => Math.abs(x - shape[i]) < k_shape_tolerance)) return;
    this.warned = true;
    console.warn(
      `sandglass: parts of ${nameOf(object)} move, or its size changes. Its shadow and the sand on it take it as it was added. ` +
        "Call removeModel and addModel where it has changed, or add parts that move as models of their own.",
    );
  }

  // Takes light and sand out of the scene, and ends the worker. What is under way is refused.
  dispose() {
    if (this.ended) return;
    this.ended = true;
    this.leave();
    this.sand?.end();
    this.stage.end();
  }
  take(drawn) {
    this.drawn = drawn;
    this.sand?.take(drawn);
    this.show(
      drawn,
      receivers.filter((name) => drawn.textures[name]),
    );
  }
}
