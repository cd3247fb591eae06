// What sandglass/three and sandglass/babylon have in common: a stage here or in a worker, and the objects that were added to it.
import { Stage } from "./stage.mjs";
import { isPose, k_ended } from "./options.mjs";
import { pixelsOf, sizeOf } from "./place_light.mjs";
import { WorkerStage, blockMade } from "./worker.mjs";
import { k_block_text } from "./block_module.mjs";
import { receivers } from "./glsl.mjs";
import { depthOf, handJoints, roomOf, viewThrough } from "./webxr.mjs";

const k_shape_frames = 20; // from one look at a model's parts to the next
const k_shape_tolerance = 1e-3; // metres, or of a size

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

// A subclass has meshOf(object, pose), shapeOf(object, pose), poseOf(object), isShown(object), cameraOf(camera),
// sandOf(block, radius), hide(object), which gives what shows it again, veilOf(object, mesh, pose), which hides and receives,
// show(drawn) and leave().
export class Engine {
  static async stageOf({ worker = false, ...options }) {
    return (worker ? WorkerStage : Stage).create(options);
  }
  constructor(stage) {
    Object.assign(this, {
      stage,
      objects: new Map(),
      room: new Map(),
      owed: 0,
      last: performance.now(),
      sand: null,
      busy: false,
    });
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
    const { model, mesh } = this.modelOf("addModel", object, "removeModel");
    Object.assign(model, { shape: this.shapeOf(object, model.pose), casts: options?.shadow !== false, shadow: true });
    await this.add(object, model, () => this.stage.addModel({ ...mesh, ...model.pose }, options));
  }
  modelOf(call, object, ends) {
    this.refuseEnded();
    if (!object?.found && typeof object?.[this.placing] !== "function")
      throw new Error(`sandglass: ${call} takes an object of the scene. Of a loaded glTF pass gltf.scene.`);
    if (this.objects.has(object))
      throw new Error(`sandglass: ${call} has this object already. Call ${ends} first, or pass a clone.`);
    return this.takenOf(call, object);
  }
  // An object's mesh and pose as they are now.
  takenOf(call, object) {
    const pose = this.poseNow(object);
    if (!isPose(pose))
      throw new Error(
        `sandglass: ${call}: ${nameOf(object)} has no finite pose. Set its position, rotation and scale first.`,
      );
    return { model: { pose }, mesh: object.found?.mesh ?? this.meshOf(object, pose) };
  }
  poseNow(object) {
    return object.found?.pose ?? this.poseOf(object);
  }
  async add(object, model, ask) {
    this.objects.set(object, model);
    try {
      model.added = (async () => ask())();
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
    if (model.place) return model.place.dispose();
    this.objects.delete(object);
    await this.stage.remove(model.number ?? (await model.added));
  }
  // A mesh of the real place, as a scanned room or a table: sand lies on it, shadows fall on it, it hides what is behind it, and it is
  // not drawn: the object is hidden for so long. Its pose is followed. Gives what takes its mesh anew, and what withdraws it.
  async addPlace(object) {
    const { model, mesh } = this.modelOf("addPlace", object, "removeModel");
    const place = { update: () => this.renewPlace(object, model), dispose: () => this.removePlace(object, model) };
    model.place = place;
    await this.add(object, model, () => this.stage.addPlace({ ...mesh, ...model.pose }));
    if (this.ended || model.gone) return place;
    if (!object.found) model.unhide = this.hide(object);
    model.veil = this.veilOf(object, mesh, model.pose);
    return place;
  }
  async renewPlace(object, model) {
    this.refuseEnded();
    if (model.gone) throw new Error("sandglass: this place has been withdrawn. Call addPlace with it.");
    const { model: now, mesh } = this.takenOf("update", object);
    const number = await this.stage.addPlace({ ...mesh, ...now.pose });
    await this.stage.fields.catch(() => {}); // what was there stays until sand lies on what is there now
    if (this.ended) return;
    const last = model.gone ? number : model.number;
    if (!model.gone) {
      model.veil.end();
      Object.assign(model, { number, pose: now.pose, veil: this.veilOf(object, mesh, now.pose) });
    }
    await this.stage.remove(last);
  }
  async removePlace(object, model) {
    if (this.ended || model.gone) return;
    model.gone = true;
    this.objects.delete(object);
    this.endPlace(model);
    await this.stage.remove(model.number ?? (await model.added));
  }
  endPlace({ unhide, veil }) {
    unhide?.();
    veil?.end();
  }
  // An image of the room as the camera sees it: a photograph or a video's picture, not a panorama.
  async see(image, camera, options) {
    this.refuseEnded();
    if (typeof camera?.[this.placing] !== "function")
      throw new Error("sandglass: see takes an image and the camera that took it.");
    await this.stage.see(pixelsOf(image), { ...this.cameraOf(camera), ...options });
  }

  // The same of a camera with a known lens, such as getUserMedia gives of a headset; `viewer`: where that was, an XRRigidTransform.
  async seeThrough(image, viewer, lens, options) {
    this.refuseEnded();
    await this.stage.see(pixelsOf(image), { ...viewThrough(viewer, lens, sizeOf(image)), ...options });
  }

  async newSand(options) {
    this.refuseEnded();
    const block = await blockMade(Uint8Array.from(atob(k_block_text), (letter) => letter.charCodeAt(0)));
    const { radius } = await this.stage.createSand(options);
    this.refuseEnded();
    this.say(() => this.stage.fields); // where sand cannot lie on a model
    this.sand?.end();
    this.sand = this.sandOf(block, radius);
  }
  // There is no sand any more, and nothing pours.
  async removeSand() {
    if (this.ended || !this.sand) return;
    this.sand.end();
    this.sand = null;
    await this.stage.createSand({ particles: 1 }); // a stage always has some, and this one stays empty
  }
  pour(...nozzles) {
    this.refuseEnded();
    return this.stage.pour(...nozzles);
  }
  push(...balls) {
    this.refuseEnded();
    return this.stage.push(...balls);
  }

  // The hands of an XRFrame push sand, as they are in that space; without it there are none.
  async seeHands(frame, space) {
    this.refuseEnded();
    await this.stage.setHands(...(frame ? handJoints(frame, space) : []));
  }
  // What getDepthInformation says of an XRView, or of what has the same; null: nothing.
  async seeDepth(depth, view) {
    this.refuseEnded();
    if (depth) await this.stage.seeDepth(depthOf(depth, view));
  }

  // The meshes that an XRFrame tells of, or else its planes, are places from now on, as they are in that space.
  async seeRoom(frame, space) {
    this.refuseEnded();
    const room = roomOf(frame, space);
    for (const [key, found] of room) {
      const known = this.room.get(key);
      if (!known && !found.pose) continue;
      found.pose ??= known.found.pose; // it is lost, and stays where it was
      if (!known) {
        const one = { found };
        this.room.set(key, one);
        one.added = this.addPlace(one);
        this.say(() => one.added);
        continue;
      }
      const { changed } = known.found;
      known.found = found;
      if (changed !== found.changed) this.say(async () => (await known.added).update());
    }
    for (const [key, one] of this.room)
      if (!room.has(key)) {
        this.room.delete(key);
        if (this.objects.has(one)) this.say(() => this.removeModel(one));
      }
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
    const pose = this.poseNow(object);
    const shown = !model.place && this.isShown(object);
    model.seen ||= shown;
    const shadow = shown || !model.seen;
    if (model.casts && shadow !== model.shadow) {
      model.shadow = shadow;
      this.say(() => this.stage.setShadow(model.number, shadow));
    }
    if (!isPose(pose)) return;
    if (String([pose.position, pose.rotation]) !== String([model.pose.position, model.pose.rotation])) {
      model.pose = pose;
      model.veil?.move(pose);
      this.say(() => this.stage.move(model.number, pose.position, pose.rotation));
    }
    if (!model.place && !this.warned && this.frames % k_shape_frames === 0) this.warnOfShape(object, model);
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
    for (const model of this.objects.values()) this.endPlace(model);
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
