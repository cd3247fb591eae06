// What sandglass/three and sandglass/babylon have in common: a stage here or in a worker, and the objects that were added to it.
import { Stage } from "./stage.mjs";
import { pixelsOf } from "./place_light.mjs";
import { WorkerStage, blockMade } from "./worker.mjs";
import { k_block_text } from "./block_module.mjs";
import { receivers } from "./glsl.mjs";

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

// A subclass has meshOf(object), poseOf(object), cameraOf(camera), sandOf(block, radius), show(drawn) and leave().
export class Engine {
  static async stageOf({ worker = false, ...options }) {
    return (worker ? WorkerStage : Stage).create(options);
  }
  constructor(stage) {
    Object.assign(this, { stage, objects: new Map(), owed: 0, last: performance.now(), sand: null, busy: false });
  }

  // An object's meshes throw a shadow, and sand lies on them. They are taken at their present size; the pose is followed.
  async addModel(object, options) {
    if (typeof object?.[this.placing] !== "function")
      throw new Error("sandglass: addModel takes an object of the scene. Of a loaded glTF pass gltf.scene.");
    const pose = this.poseOf(object);
    this.objects.set(object, {
      pose,
      number: await this.stage.addModel({ ...this.meshOf(object, pose), ...pose }, options),
    });
    this.watchFields();
  }
  async removeModel(object) {
    if (!this.objects.has(object)) throw new Error("sandglass: removeModel takes an object that addModel was given.");
    const { number } = this.objects.get(object);
    this.objects.delete(object);
    await this.stage.remove(number);
  }
  // An image of the room as the camera sees it: a photograph or a video's picture, not a panorama.
  async see(image, camera, options) {
    if (typeof camera?.[this.placing] !== "function")
      throw new Error("sandglass: see takes an image and the camera that took it.");
    await this.stage.see(pixelsOf(image), { ...this.cameraOf(camera), ...options });
  }

  async newSand(options) {
    const [{ radius }, block] = await Promise.all([
      this.stage.createSand(options),
      blockMade(Uint8Array.from(atob(k_block_text), (letter) => letter.charCodeAt(0))),
    ]);
    this.watchFields();
    this.sand?.end();
    this.sand = this.sandOf(block, radius);
  }
  // Where sand cannot lie on a model, that is said once; the rest goes on.
  watchFields() {
    Promise.resolve(this.stage.fields).catch(({ message }) => console.error(message));
  }
  pour(...nozzles) {
    return this.stage.pour(...nozzles);
  }
  push(...balls) {
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
    for (const [object, model] of this.objects) {
      const pose = this.poseOf(object);
      if (
        String(pose.position) === String(model.pose.position) &&
        String(pose.rotation) === String(model.pose.rotation)
      )
        continue;
      model.pose = pose;
      this.stage.move(model.number, pose.position, pose.rotation);
    }
    const drawn = this.stage.frame(Math.min(this.owed, 0.1));
    this.owed = 0;
    if (!(drawn instanceof Promise)) return this.take(drawn);
    this.busy = true;
    drawn
      .then((arrived) => this.ended || this.take(arrived))
      .finally(() => {
        this.busy = false;
      });
  }
  // Takes light and sand out of the scene, and ends the worker. Materials keep the last shadows.
  dispose() {
    this.ended = true;
    this.leave();
    this.sand?.end();
    this.stage.call?.end();
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
