// sandglass/stage: models, sand, shadows and the room's light on one floor, for any renderer; none is imported. An app adds
// models, shows images of the room, and calls frame(): it gives what has to be drawn anew. The world is right-handed, y up,
// in metres. sandglass/worker has the same methods in a Worker.
import { load, constants } from "./sandglass.mjs";
import { SkinChanges } from "./skin_changes.mjs";
import { fieldMade } from "./worker.mjs";

const C = constants, k_colliders = 64, k_nozzles = 8, k_models = 32;
const k_texels = { pile: 128, sky: 64, shadow: 256, occlusion: 128 };
const k_cast = { texels: k_texels.shadow, ambient_texels: k_texels.occlusion, mesh_capacity: k_models, reach: 0 };  // all models cast
const k_cast_textures = [["shadow", "occlusion"], ["wallShadow", "wallOcclusion"]];  // of the floor and the wall
const k_pile_textures = ["pile", "onSand", "sky", "skyOnSand"];  // in the order of sandglass_pile_shadow_part
const k_coarse = 0.125;       // of the smallest model's side: texels are as large as that at most, or it is said
const k_fade = 5;             // seconds after an image in which light and shadows are told anew
const k_field_nodes = 4e6;   // at most: a large model gets a coarser field
const k_longest_side = 256;  // pixels of an image that are read
// What calls take: how many numbers, 1 above 0; 0: something else.
const k_options = { sand: 0, source: 0, threads: 1, origin: 3, half: 1, budget: 1 }, k_model = { shadow: 0, collide: 0 };
const k_nozzle = { position: 3, rotation: 4, radius: 1, speed: 1 }, k_sand = { particles: 1, radius: 1 };

// Refuses an option that there is not, and what is no such number.
export function checked(what, given, kinds) {
  for (const [name, value] of Object.entries(given)) {
    const count = kinds[name], numbers = count > 1 ? Array.from(value ?? []) : [value];
    if (count === undefined) throw new Error(`sandglass: ${what} takes no "${name}". It takes: ${Object.keys(kinds).join(", ")}.`);
    if (!count || value === undefined || (numbers.length === count && numbers.every(Number.isFinite) && (count > 1 || value > 0))) continue;
    throw new Error(`sandglass: ${what}: ${name} must be ${count > 1 ? `${count} numbers: an array or a vector` : "a number above 0"}.`);
  }
}

// The field of a mesh: its bytes, for another instance's memory too.
export function fieldOf(sand, { positions, indices }, spacing) {
  const used = [], keep = (block) => { used.push(block); return block; };
  try {
    const mesh = keep(sand.make("sandglass_mesh", { vertices: keep(sand.put(positions)), vertex_count: positions.length / 3,
      indices: keep(sand.put(indices)), triangle_count: indices.length / 3 }));
    const inside = keep(sand.create("sandglass_mesh_inside", mesh, C.SANDGLASS_INSIDE_WINDING));
    const desc = keep(sand.make("sandglass_field_desc", { solid: C.SANDGLASS_SOLID_INSIDE, mesh, inside: sand.pointer("sandglass_mesh_inside_test"), inside_user: inside }));
    sand.sandglass_mesh_bounds(mesh, desc.bounds_min, desc.bounds_max);
    const volume = [...desc.bounds_max].reduce((product, high, k) => product * (high - desc.bounds_min[k] + 8 * spacing), 1);
    desc.spacing = Math.max(spacing, Math.cbrt(volume / k_field_nodes)), desc.band = 4 * desc.spacing;
    for (let k = 0; k < 3; ++k) desc.bounds_min[k] -= desc.band, desc.bounds_max[k] += desc.band;
    const size = keep(sand.allocate(8));
    sand.sandglass_field_bytes(desc, size);
    return sand.bytes(keep(sand.create("sandglass_field", desc)), Number(sand.view().getBigUint64(size, true))).slice();
  } finally {
    for (const block of used) sand.free(block);
  }
}

// What see() takes, of an image, a video or a canvas.
export function pixelsOf(image) {
  if (image?.data) return image;
  const full = [image?.videoWidth || image?.naturalWidth || image?.width, image?.videoHeight || image?.naturalHeight || image?.height];
  if (!(full[0] > 1 && full[1] > 1)) throw new Error("sandglass: see takes an image element, an ImageBitmap, a canvas or a video that is loaded.");
  const [width, height] = full.map((side) => Math.max(1, Math.round(side * Math.min(1, k_longest_side / Math.max(...full)))));
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  try { context.drawImage(image, 0, 0, width, height); } catch { throw new Error("sandglass: see takes an image element, an ImageBitmap, a canvas or a video. Of a texture pass its image."); }
  return { data: context.getImageData(0, 0, width, height).data, width, height };
}

export class Stage {
  // `sand`: of load(); or `source` and `threads` for it. `origin`: a point of the floor; sand throws shadows up to `half`
  // metres around it. `budget`: milliseconds that a frame of the library may take.
  static async create(options = {}) {
    checked("createStage", options, k_options);
    const { sand, source, threads = 1, origin = [0, 0, 0], half = 0.64, budget = 8 } = options;
    return new Stage(sand ?? await load(source, { threads }), { origin, half, budget });
  }

  constructor(sand, options) {
    Object.assign(this, { sand, options, models: new Map(), nozzles: [], hands: [], shown: {}, next: 1, images: 0, fading: k_fade, cast: 0, casts: [], planes: [{ x: [1, 0, 0], z: [0, 0, 1], at: [0, 0, 0] }], boxes: {}, room: 0, fields: Promise.resolve(), unmade: 0 });
    this.made("room", "sandglass_room");
    this.words = sand.allocate(4 * C.SANDGLASS_LIGHT_CELLS), this.castList = sand.allocate(8);
    for (const name of ["camera_image", "room_light", "room_place", "filament_light", "frame_input", "frame_report",
      "texture"]) this[name] = sand.make(`sandglass_${name}`);
    this.lights = sand.make("sandglass_light"), this.light = sand.make("sandglass_room_light"), this.light.struct_size = 0;
    sand.sandglass_room_place_default(this.room_place);
    this.room_place.set({ position: options.origin, shown: this.light });
    this.colliders = sand.array("sandglass_collider", k_colliders), this.emitters = sand.array("sandglass_emitter", k_nozzles);
    this.meshes = sand.array("sandglass_cast_mesh", k_models);
    sand.sandglass_frame_input_default(this.frame_input);
    this.frame_input.set({ budget_ns: Math.round(options.budget * 1e6), colliders: this.colliders.address, emitters: this.emitters.address, casts: this.castList, cast_count: 1 });
    this.newScene({}), this.newCast(4096);
    sand.sandglass_room_get(this.room, this.room_place, this.room_light);
  }

  // One of the library's objects.
  make(name, fields = {}, ...more) {
    const { sand } = this, desc = sand.make(`${name}_desc`);
    sand[`${name}_desc_default`](desc, ...more);
    desc.set(typeof fields === "function" ? fields(desc) : fields);
    try { return sand.create(name, desc); } finally { sand.free(desc); }
  }
  // The same, in place of the one before.
  made(key, ...values) {
    if (this[key]) this.sand.destroy(this[key]), this[key] = 0;
    this[key] = this.make(...values);
  }

  newScene(granular) {
    const { sand } = this;
    this.made("scene", "sandglass_scene", (desc) => {
      desc.granular.set({ ...granular, collider_capacity: k_colliders, emitter_capacity: k_nozzles });
      if (granular.particle_capacity) this.made("skin", "sandglass_skin", {}, desc.granular);
      return { clock: sand.sandglass_clock_system(), parallel: sand.parallel };
    });
    this.frame_input.skin = this.skin ?? 0;
  }

  newCast(triangles) {
    const { sand, options } = this, plane = sand.make("sandglass_cast_plane");
    this.made("cast", "sandglass_cast", { ...k_cast, triangle_capacity: this.triangles = triangles });
    sand.sandglass_cast_plane_default(plane);
    plane.origin.set(options.origin);
    sand.sandglass_cast_set_plane(this.cast, plane), sand.free(plane);
    sand.view().setUint32(this.castList, this.casts[0] = this.cast, true), this.fading = k_fade;
  }

  // Shadows on another plane, too: its axes, whose y is the normal, and how far it reaches along x and z. A frame whose
  // cast_count is 1 leaves it out.
  setWall({ x, y, z, at, low, high }) {
    const { sand, casts, castList, triangles } = this;
    if (!this.wallPlane) {
      this.wallPlane = sand.make("sandglass_cast_plane");
      casts[1] = this.make("sandglass_cast", { ...k_cast, triangle_capacity: triangles });
      sand.view().setUint32(castList + 4, casts[1], true), this.castModels();
    }
    sand.sandglass_cast_plane_default(this.wallPlane);
    this.wallPlane.set({ origin: at, normal: y, along: x, low, high });
    sand.sandglass_cast_set_plane(casts[1], this.wallPlane);
    this.planes[1] = { x, z, at };
  }

  // Sand of so many particles of a radius in metres; further fields are those of sandglass_granular_desc. Sand that was
  // there is gone.
  createSand({ particles = 3000, radius = 0.006, ...granular } = {}) {
    checked("createSand", { particles, radius }, k_sand);
    this.newScene({ particle_capacity: particles, particle_radius: radius, static_friction: 0.6, kinetic_friction: 0.55, ...granular });
    this.newPile(), this.take(this.skin, radius);
    for (const model of this.models.values()) this.giveField(model);
    return { radius };
  }

  newPile() {
    const { origin: [x, y, z], half } = this.options;
    this.made("pile", "sandglass_pile_shadow", { low: [x - half, z - half], high: [x + half, z + half], floor: y, texels: k_texels.pile, sky_texels: k_texels.sky });
    this.frame_input.pile_shadow = this.pile, this.shown = {}, this.fading = k_fade;
  }
  // The skin that is drawn from now on, and the radius of its particles.
  take(skin, radius) { this.radius = radius, this.changes = new SkinChanges(this.sand, skin); }

  // A mesh in its own frame (metres, its present size) and its pose. `shadow`: it throws one. `collide`: sand lies on it, as
  // soon as a worker has made its field; `fields` resolves then, and nothing is poured before. Gives the number that move()
  // and remove() take.
  addModel({ positions, indices, position, rotation }, options = {}) {
    checked("addModel", options, k_model);
    const { sand, models } = this, count = indices.length / 3, { shadow = true, collide = true } = options;
    if (models.size === k_models) throw new Error(`sandglass: a stage holds ${k_models} models. Remove one, or join their meshes.`);
    if (!(count > 0)) throw new Error("sandglass: the model has no triangles. Add an object that has a mesh.");
    const low = [Infinity, Infinity, Infinity], high = low.map((x) => -x);
    positions.forEach((x, i) => { low[i % 3] = Math.min(low[i % 3], x), high[i % 3] = Math.max(high[i % 3], x); });
    const model = { position, rotation, shadow, collide, count, vertices: positions.length / 3, positions: sand.put(positions), indices: sand.put(indices), field: 0, side: Math.max(...high.map((x, k) => x - low[k])) };
    models.set(this.next, model);
    const triangles = [...models.values()].reduce((sum, one) => sum + (one.shadow ? 2 * one.count : 0), 0);
    if (triangles > this.triangles) this.newCast(2 * triangles);
    this.moved = true;
    this.giveField(model);
    return this.next++;
  }

  giveField(model) {
    if (!this.radius || !model.collide || model.field) return;
    const { sand, radius } = this, { positions, indices, vertices, count } = model;
    const mesh = { positions: sand.floats(positions, 3 * vertices).slice(), indices: new Uint32Array(sand.memory.buffer, indices, 3 * count).slice() };
    const field = typeof Worker === "undefined" ? Promise.resolve(fieldOf(sand, mesh, radius)) : fieldMade(sand.module, mesh, radius);
    ++this.unmade;
    this.fields = Promise.all([this.fields.catch(() => {}), field.then((made) => { if (model.count && !model.field) model.field = sand.put(made); }, (error) => {
      throw new Error(`sandglass: sand cannot lie on a model: ${error.message} Add it with { collide: false }, or take smaller sand.`);
    }).finally(() => { --this.unmade; })]);
    this.fields.catch(() => {});  // told to whoever asks
  }

  move(number, position, rotation) { Object.assign(this.models.get(number), { position, rotation }), this.moved = true; }
  remove(number) {
    const model = this.models.get(number);
    this.models.delete(number), this.castModels();
    for (const block of [model.positions, model.indices, model.field]) this.sand.free(block);
    model.count = 0;
  }

  // Nozzles that are open from now on: { position, rotation, radius, speed }; none closes them.
  pour(...nozzles) {
    if (!this.radius) throw new Error("sandglass: there is no sand to pour. Call createSand first.");
    for (const nozzle of nozzles) checked("a nozzle", { position: null, ...nozzle }, k_nozzle);
    this.nozzles = nozzles.slice(0, k_nozzles).map((nozzle) => ({ rotation: [0, 0, 0, 1], radius: 4 * this.radius, speed: 0.8, ...nozzle, position: Array.from(nozzle.position) }));
  }
  // Balls that push sand from now on: { position, radius, velocity }.
  push(...balls) { this.hands = balls.slice(0, k_colliders - 1 - k_models); }

  // RGBA bytes, the upper row first, of a camera that looks along -z of `orientation`. The first image is taken as it is;
  // light of later ones fades in.
  see({ data, width, height }, { orientation = [0, 0, 0, 1], position = [0, 0, 0], diagonal = 75, exposure = 0, ms = performance.now() } = {}) {
    const { sand, camera_image: image, words } = this, pixels = sand.put(data), focal = sand.sandglass_camera_focal(width, height, diagonal);
    sand.sandglass_camera_image_default(image);
    image.set({ format: C.SANDGLASS_CAMERA_RGBA, width, height, focal_x: focal, focal_y: focal, centre_x: (width - 1) / 2, centre_y: (height - 1) / 2,
      planes: [pixels, 0, 0], strides: [4 * width, 0, 0], orientation, position, exposure, timestamp_ns: Math.round(ms * 1e6) });
    try { sand.sandglass_room_set_image(this.room, image, words); } finally { sand.free(pixels); }
    if (this.images++ === 0) this.light.struct_size = 0;
    this.fading = k_fade;
    sand.sandglass_room_get(this.room, this.room_place, this.room_light);
  }

  // Something is placed there. It begins in the light that is known; the fade is for what has stood there.
  stand(position) {
    this.room_place.position.set(position), this.light.struct_size = 0;
    this.sand.sandglass_room_get(this.room, this.room_place, this.room_light);
  }
  // For another frame of the world.
  forget() {
    this.sand.sandglass_room_reset(this.room);
    this.sand.sandglass_room_get(this.room, this.room_place, this.room_light);
  }

  // Lets the light fade, and tells the shadows.
  follow(seconds) {
    const light = this.fade(seconds);
    this.shade(light.toLight, [...this.light.ambient_cells], this.light.main_angular_diameter);
    return light;
  }
  // Gives the room's light: the direction and irradiance of the main light, the rest as radiance (nine harmonics) and as
  // irradiance over pi (nine terms of a polynomial, see sandglass_filament_light).
  fade(seconds) {
    const { sand, light, lights, filament_light: filament } = this;
    sand.sandglass_room_fade(light, this.room_light, seconds);
    sand.sandglass_light_of_room(light, lights);
    sand.sandglass_light_to_filament(lights, C.SANDGLASS_LIGHT_AMBIENT, 1, filament);
    return { toLight: [...lights.towards], facing: [...lights.facing], radiance: [...lights.ambient_sh], ambient: [...filament.sh], floor: [...light.floor] };
  }
  // Shadows of a light: towards the main one, the cells where the rest comes from, and how large it is, radians; 0: not known.
  shade(toLight, cells, diameter = 0) {
    const { sand, words, casts, pile } = this, sum = Math.max(cells.reduce((all, cell) => all + cell, 0), 0.001);
    for (const [kind, handle] of [...casts.map((cast) => ["cast", cast]), ["pile_shadow", pile]]) {
      if (!handle) continue;
      sand.floats(words, 3).set(toLight);
      sand[`sandglass_${kind}_set_light`](handle, words, diameter);
      // What is drawn by these cells is the light without the main one: they are 1 together.
      sand.floats(words, C.SANDGLASS_LIGHT_CELLS).set(cells.map((cell) => cell / sum));
      sand[`sandglass_${kind}_set_cells`](handle, words);
    }
  }

  castModels() {
    const { sand, meshes, models } = this, casting = [...models].filter(([, { shadow }]) => shadow);
    casting.forEach(([version, { positions, vertices, indices, count, position, rotation }], i) => {
      sand.sandglass_cast_mesh_default(meshes[i]);
      meshes[i].set({ positions, vertex_count: vertices, indices, triangle_count: count, version, world_from_mesh: matrixOf(position, rotation) });
    });
    for (const cast of this.casts) sand.sandglass_cast_set_meshes(cast, meshes, casting.length);
    this.moved = false;
  }

  // All models share one texture: where they stand far apart its texels, of so many metres, are too coarse for the smallest.
  warn(texel) {
    const casting = [...this.models.values()].filter(({ shadow }) => shadow);
    if (this.warned || casting.length < 2 || texel <= k_coarse * Math.min(...casting.map(({ side }) => side))) return;
    this.warned = true;
    console.warn(`sandglass: models stand so far apart that their shadow has texels of ${(100 * texel).toFixed(1)} cm. Put them nearer together, or give each place a stage of its own.`);
  }

  // So many seconds go by. Gives what drawn() says.
  frame(seconds) {
    const { sand, colliders, emitters, frame_input: input, frame_report: report } = this;
    if (this.fading > 0) this.fading -= seconds, this.lit = this.follow(seconds);
    if (this.moved) this.castModels();
    const still = { rotation: [0, 0, 0, 1], size: [1, 1, 1], linear_velocity: [0, 0, 0], field: 0, id: 0 }, all = [{ shape: C.SANDGLASS_SHAPE_HALF_SPACE, position: this.options.origin }];
    for (const [id, { position, rotation, field }] of this.models) if (field) all.push({ shape: C.SANDGLASS_SHAPE_FIELD, position, rotation, field, id });
    for (const { position, radius, velocity = [0, 0, 0] } of this.hands) all.push({ shape: C.SANDGLASS_SHAPE_SPHERE, position, size: [radius, 0, 0], linear_velocity: velocity });
    all.forEach((one, i) => colliders[i].set({ ...still, ...one }));
    this.nozzles.forEach((nozzle, i) => emitters[i].set(nozzle));
    input.set({ time_step: seconds, collider_count: this.radius ? all.length : 0, emitter_count: this.radius && this.unmade === 0 ? this.nozzles.length : 0 });
    sand.sandglass_scene_frame(this.scene, input, report);
    return this.drawn(this.lit);
  }

  // What changed since the call before. Its arrays are views of the module's memory, valid until the next call.
  drawn(light) {
    const { sand, shown, texture, options: { origin: [x, y, z], half } } = this;
    let behind = 0;  // of textures that show what was
    const textures = {}, changed = (key, version) => shown[key] !== version && (shown[key] = version, true);
    const take = (name) => { textures[name] = { side: texture.side, bytes: sand.bytes(texture.bytes, texture.side ** 2) }; };
    const dot = (a, b) => a.reduce((sum, c, k) => sum + c * b[k], 0);
    this.casts.forEach((handle, i) => k_cast_textures[i].forEach((name, k) => {
      sand[`sandglass_cast_get_${k === 0 ? "texture" : "ambient"}`](handle, texture);
      behind += texture.behind;
      if (!texture.valid || !changed(name, `${handle} ${texture.version}`)) return;
      const { x, z, at } = this.planes[i], { corner, along, across } = texture;
      if (name === "shadow") this.warn(Math.hypot(...along) / texture.side);
      take(name), this.boxes[name] = [dot(x, corner) - dot(x, at), dot(z, corner) - dot(z, at), 1 / dot(x, along), 1 / dot(z, across)];
    }));
    const boxes = { shadow: [0, 0, 0, 0], occlusion: [2, 2, 0, 0], ...this.boxes };
    const out = { light, textures, floor: y, pileBox: [x - half, z - half, 0.5 / half, 0.5 / half], shadowBox: boxes.shadow, occlusionBox: boxes.occlusion, boxes,
      shadowOpacity: this.boxes.shadow ? 1 : 0, pileOpacity: 0, skyKnown: 0, milliseconds: this.frame_report.time.elapsed_ns / 1e6, particles: this.frame_report.sand.particles };
    if (this.radius) k_pile_textures.forEach((name, part) => {
      sand.sandglass_pile_shadow_get_texture(this.pile, part, texture);
      behind += texture.behind;
      if (name === "pile" && texture.valid) out.pileOpacity = texture.scale;
      if (name === "sky") out.skyKnown = texture.valid;
      if (texture.valid && changed(name, texture.version)) take(name);
    });
    this.behind = behind;
    if (!this.radius) return out;
    const skin = this.changes.take();
    const streams = this.nozzles.slice(0, 3).map(({ position, rotation, radius, speed }) => ({ nozzle: [...position, radius], way: [...matrixOf(position, rotation).slice(4, 7).map((c) => -c), speed] }));
    return Object.assign(out, { skin, streams, radius: this.radius });
  }
}

// Column-major, of a pose.
export function matrixOf([px, py, pz], [x, y, z, w]) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0, 2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0, px, py, pz, 1];
}
