// sandglass/stage: models, sand, shadows and the room's light on one floor, for any renderer; none is imported. An app adds
// models, shows images of the room, and calls frame(): it gives what has to be drawn anew. The world is right-handed, y up,
// in metres. sandglass/worker has the same methods in a Worker.
import { load, constants } from "./sandglass.mjs";
import { SkinChanges } from "./skin_changes.mjs";
import {
  ballsOf,
  checked,
  handsOf,
  k_balls,
  k_model_options,
  k_nozzles,
  k_options,
  k_sand_options,
  k_view_options,
  nozzlesOf,
  numbersOf,
  poseOf,
} from "./options.mjs";
import { checkedMesh, fieldOf, made, matrixOf } from "./mesh_field.mjs";
import { PlaceLight } from "./place_light.mjs";
import { StageHands, k_hand_bodies } from "./stage_hands.mjs";
import { StagePlace, isSolid } from "./stage_place.mjs";
import { StageShadows } from "./stage_shadows.mjs";
import { fieldMade } from "./worker.mjs";

const k_models = 32; // and places that are solid
const k_colliders = 2 + k_models + k_balls + k_hand_bodies; // with the floor and what is open of the place
const k_streams = 3; // of nozzles, that are drawn
const k_most_particles = 4e6;
const k_finest = 0.0001; // metres, of a particle
const k_coarsest = 10;
const k_widest = 99; // particles, of a nozzle's radius
const k_fastest = 100; // metres a second, of a nozzle
const k_high = 1; // metres above the floor, up to which places show shadows
const k_fade = 5; // seconds after an image in which light and shadows are told anew
const k_friction = { static_friction: 0.6, kinetic_friction: 0.55 };
const k_still = { rotation: [0, 0, 0, 1], size: [1, 1, 1], linear_velocity: [0, 0, 0], field: 0, relief: 0, id: 0 };

export class Stage {
  #options;
  #loaded = false; // its module, by create()
  #models = new Map();
  #next = 1; // number of a model
  #moved = false;
  #light;
  #shown_light;
  #fading = k_fade;
  #shadows;
  #scene = 0;
  #skin = 0;
  #radius = 0; // of the particles that are drawn
  #changes; // of the skin that is drawn
  #nozzles = [];
  #balls = [];
  #hands = new StageHands();
  #place;
  #fields = Promise.resolve();
  #unmade = 0; // fields
  #input;
  #report;
  #colliders;
  #emitters;

  // `sand`: of load(); or `source` and `threads` for it. `origin`: a point of the floor; sand throws shadows up to `half`
  // metres around it. `height`: metres above the floor, up to which materials that receive shadows stand; without it their
  // shadow is that of the floor. `budget`: milliseconds that a frame of the library may take.
  static async create(options = {}) {
    checked("createStage", options, k_options);
    const { sand, source, threads = 1, ...own } = options;
    const stage = new Stage(sand ?? (await load(source, { threads })), own);
    stage.#loaded = !sand;
    return stage;
  }
  end() {
    if (this.#loaded) this.sand.end();
  }

  constructor(sand, { origin = [0, 0, 0], half = 0.64, height, budget = 8, reflections = false } = {}) {
    this.sand = sand;
    this.#options = { origin: numbersOf(origin, 3), half, height };
    this.#light = new PlaceLight(sand, this.#options.origin, reflections);
    this.#shadows = new StageShadows(sand, this.#options, k_models);
    this.#place = new StagePlace(sand, this.#options);
    this.#report = sand.make("sandglass_frame_report");
    this.#colliders = sand.array("sandglass_collider", k_colliders);
    this.#emitters = sand.array("sandglass_emitter", k_nozzles);
    this.#input = sand.make("sandglass_frame_input");
    sand.sandglass_frame_input_default(this.#input);
    this.#input.set({
      budget_ns: Math.round(budget * 1e6),
      colliders: this.#colliders.address,
      emitters: this.#emitters.address,
    });
    this.#newScene({});
  }

  // What is refused leaves the scene and the skin as they were.
  #newScene(granular) {
    const { sand } = this;
    let skin = 0;
    let scene;
    try {
      scene = made(sand, "sandglass_scene", (desc) => {
        desc.granular.set({ ...granular, collider_capacity: k_colliders, emitter_capacity: k_nozzles });
        if (granular.particle_capacity) skin = made(sand, "sandglass_skin", {}, desc.granular);
        return { clock: sand.sandglass_clock_system(), parallel: sand.parallel };
      });
    } catch (error) {
      sand.destroy(skin);
      throw error;
    }
    for (const before of [this.#scene, this.#skin]) sand.destroy(before);
    this.#scene = scene;
    this.#input.skin = this.#skin = skin;
  }

  // ---- Sand

  // Sand of so many particles of a radius in metres; further fields are those of sandglass_granular_desc. Sand that was
  // there is gone.
  createSand({ particles = 3000, radius = 0.006, ...granular } = {}) {
    checked("createSand", { particles, radius }, k_sand_options);
    if (particles > k_most_particles || !Number.isInteger(particles) || radius < k_finest || radius > k_coarsest)
      throw new Error(
        `sandglass: createSand makes no ${particles} particles of ${radius} m. ` +
          `Pass at most ${k_most_particles}, a whole number, of a radius from ${k_finest} to ${k_coarsest} m.`,
      );
    const pile = this.#shadows.madePile();
    try {
      this.#newScene({ particle_capacity: particles, particle_radius: radius, ...k_friction, ...granular });
    } catch (error) {
      this.sand.destroy(pile);
      throw error;
    }
    this.#shadows.takePile(pile);
    this.#fading = k_fade;
    this.#draw(this.#skin, radius);
    for (const model of this.#models.values()) this.#giveField(model);
    return { radius };
  }
  #draw(skin, radius) {
    this.#radius = radius;
    this.#changes = new SkinChanges(this.sand, skin);
  }

  // Draws the sand of a scene that is not the stage's.
  showSand(skin, radius) {
    if (this.#shadows.hasPile) this.#shadows.refresh();
    else this.#shadows.takePile(this.#shadows.madePile());
    this.#draw(skin, radius);
  }
  // What the frames of such a scene take, so that they make the stage's shadows.
  get frameFields() {
    return { ...this.#shadows.fields, skin: this.#changes?.skin ?? 0 };
  }
  // What each frame of it takes of the real place: fields, and a collider or none.
  takePlace() {
    this.#shadows.setGround(this.#place.heights);
    return { fields: this.#place.fields(), bodies: this.#place.bodies };
  }
  refresh() {
    this.#shadows.refresh();
    this.sand.sandglass_skin_refresh(this.#changes.skin);
  }

  // Nozzles that are open from now on: { position, rotation, radius, speed }; none closes them.
  pour(...nozzles) {
    if (!this.#radius) throw new Error("sandglass: there is no sand to pour. Call createSand first.");
    const usual = { rotation: [0, 0, 0, 1], radius: 4 * this.#radius, speed: 0.8 };
    const taken = nozzlesOf(nozzles).map((nozzle) => ({ ...usual, ...nozzle }));
    const widest = +(k_widest * this.#radius).toPrecision(3);
    for (const { radius, speed } of taken)
      if (radius < this.#radius || radius > widest || speed > k_fastest)
        throw new Error(
          `sandglass: a nozzle of radius ${radius} and speed ${speed} does not pour. ` +
            `Pass a radius from ${this.#radius} to ${widest} m, and at most ${k_fastest} m/s.`,
        );
    this.#nozzles = taken;
  }
  // Balls that push sand from now on: { position, radius, velocity }.
  push(...balls) {
    this.#balls = ballsOf(balls);
  }
  // Hands that push sand from now on: of each the 25 joints of WebXR in their order, { position, radius }, or null where it is lost.
  setHands(...hands) {
    this.#hands.take(handsOf(hands));
  }

  // ---- Models

  // A mesh in its own frame (metres, its present size) and its pose. `shadow`: it throws one. `collide`: sand lies on it, as
  // soon as a worker has made its field; `fields` resolves then, and nothing is poured before. Gives the number that move()
  // and remove() take.
  addModel({ position, rotation, ...mesh }, options = {}) {
    checked("addModel", options, k_model_options);
    return this.#add(checkedMesh(mesh), poseOf("addModel", position, rotation), {
      shadow: true,
      collide: true,
      ...options,
    });
  }
  // A mesh of the real place: sand lies on it, and it throws no shadow, which the place shows itself. What is closed is as solid
  // as a model. Of what is open, as a scan of a room, the highest surface counts up to 0.5 m above the floor, within `half`.
  addPlace({ position, rotation, ...mesh }) {
    const known = checkedMesh(mesh);
    const pose = poseOf("addPlace", position, rotation);
    const solid = isSolid(known);
    const top = this.#place.makeRoom(this.#open.length + !solid, known, pose, solid);
    if (this.#shadows.raise(Math.min(top, k_high))) {
      this.#fading = k_fade;
      this.#moved = true;
    }
    return this.#add(known, pose, { shadow: false, collide: solid, open: !solid });
  }
  #add({ positions, indices, ...known }, pose, { shadow, collide, open = false }) {
    if (!open && this.#models.size - this.#open.length === k_models)
      throw new Error(`sandglass: a stage holds ${k_models} models. Remove one, or join their meshes.`);
    const blocks = [];
    try {
      if (shadow) this.#makeRoom(2, this.#triangles + known.count);
      for (const array of [positions, indices]) blocks.push(this.sand.put(array));
    } catch (error) {
      for (const block of blocks) this.sand.free(block);
      throw error;
    }
    const model = { ...known, ...pose, shadow, collide, open, positions: blocks[0], indices: blocks[1], field: 0 };
    this.#models.set(this.#next, model);
    this.#moved = true;
    this.#giveField(model);
    return this.#next++;
  }
  get #open() {
    return [...this.#models].filter(([, { open }]) => open);
  }
  // Of WebXR: { data, width, height, toMetres, focal, centre, position, orientation } of the depth camera. Focal lengths and the
  // middle are in pixels; the camera looks along -z of the image as it is stored.
  seeDepth(image) {
    this.#place.see(image);
  }
  // What is known of the place's heights; 0: nothing.
  get relief() {
    return this.#place.relief;
  }
  #model(number) {
    const model = this.#models.get(number);
    if (!model) throw new Error(`sandglass: there is no model ${number}. Pass a number that addModel gave.`);
    return model;
  }
  get #casting() {
    return [...this.#models].filter(([, { shadow }]) => shadow);
  }
  get #triangles() {
    return this.#casting.reduce((sum, [, { count }]) => sum + count, 0);
  }
  // For the triangles of what casts: one that the floor cuts may need room for two.
  #makeRoom(needed, triangles) {
    this.#shadows.refuseMany(triangles);
    if (!this.#shadows.fits(needed * triangles)) this.reserve(4 * triangles);
  }
  reserve(triangles) {
    if (!this.#shadows.reserve(triangles)) return;
    this.#fading = k_fade;
    this.#moved = true;
  }

  #giveField(model) {
    if (!this.#radius || !model.collide || model.field) return;
    const { sand } = this;
    const { positions, indices, vertices, count } = model;
    const mesh = {
      positions: sand.floats(positions, 3 * vertices).slice(),
      indices: new Uint32Array(sand.memory.buffer, indices, 3 * count).slice(),
    };
    const here = typeof Worker === "undefined";
    const field = here
      ? new Promise((done) => done(fieldOf(sand, mesh, this.#radius)))
      : fieldMade(sand.module, mesh, this.#radius);
    const taken = field.then(
      (bytes) => {
        if (model.count && !model.field) model.field = sand.put(bytes);
      },
      ({ message }) => {
        const instead = "Add it with { collide: false }, or take smaller sand.";
        throw new Error(`sandglass: sand cannot lie on a model: ${message.replace(/^sandglass: /, "")} ${instead}`);
      },
    );
    ++this.#unmade;
    const last = taken.finally(() => {
      --this.#unmade;
    });
    this.#fields = Promise.all([this.#fields.catch(() => {}), last]);
    this.#fields.catch(() => {}); // told to whoever asks
  }
  get fields() {
    return this.#fields;
  }

  move(number, position, rotation) {
    Object.assign(this.#model(number), poseOf("move", position, rotation));
    this.#moved = true;
  }
  remove(number) {
    const model = this.#model(number);
    this.#models.delete(number);
    this.#castModels();
    for (const block of [model.positions, model.indices, model.field]) this.sand.free(block);
    model.count = 0;
  }

  // Whether a model throws a shadow from now on.
  setShadow(number, shadow) {
    const model = this.#model(number);
    if (shadow && !model.shadow) this.#makeRoom(2, this.#triangles + model.count);
    model.shadow = shadow;
    this.#moved = true;
  }
  // These models throw shadows from now on, and no others.
  castOnly(...numbers) {
    this.#makeRoom(
      1,
      numbers.reduce((sum, number) => sum + (this.#models.get(number)?.count ?? 0), 0),
    );
    for (const [number, model] of this.#models) model.shadow = numbers.includes(number);
    this.#castModels();
  }
  #castModels() {
    this.#shadows.setModels(this.#casting);
    this.#place.setMeshes(this.#open);
    this.#moved = false;
  }
  // Models throw shadows on this plane, too: its axes, whose y is the normal, and how far it reaches along x and z. null:
  // there is none.
  setWall(wall) {
    if (!this.#shadows.setWall(wall)) return;
    this.#castModels();
    this.#fading = k_fade;
  }

  // ---- Light

  // RGBA bytes, the upper row first, of a camera that looks along -z of `orientation`. The first image is taken as it is;
  // light of later ones fades in.
  see(image, view = {}) {
    const usual = { orientation: [0, 0, 0, 1], position: [0, 0, 0], diagonal: 75, centre: [0, 0], exposure: 0 };
    this.#light.see(image, { ...usual, ms: performance.now(), ...checked("see", view, k_view_options) });
    this.#fading = k_fade;
  }
  get images() {
    return this.#light.images;
  }
  get room() {
    return this.#light.room;
  }
  get roomLight() {
    return this.#light.now;
  }
  get fadedLight() {
    return this.#light.faded;
  }

  // Something is placed there. It begins in the light that is known; the fade is for what has stood there.
  stand(position) {
    this.#light.stand(numbersOf(position, 3));
  }
  // For another frame of the world.
  forget() {
    this.#place.forget();
    this.#light.forget();
  }

  // Gives the room's light: the direction and irradiance of the main light, the rest as radiance (nine harmonics) and as
  // irradiance over pi (nine terms of a polynomial, see sandglass_filament_light).
  fade(seconds) {
    return this.#light.fade(seconds);
  }
  // Shadows of a light: towards the main one, the cells where the rest comes from, and how large it is, radians; 0: not known.
  shade(toLight, cells, diameter = 0) {
    this.#shadows.setLight(numbersOf(toLight, 3), cells, diameter);
  }
  shadeWall(cells) {
    this.#shadows.setWallCells(cells);
  }

  // ---- Frames

  // So many seconds go by. Gives what drawn() says.
  frame(seconds) {
    if (!(seconds >= 0 && seconds < Infinity))
      throw new Error("sandglass: frame takes the seconds since the last frame.");
    if (this.#fading > 0) {
      this.#fading -= seconds;
      this.#shown_light = this.fade(seconds);
      const { ambient_cells: cells, main_angular_diameter: diameter } = this.fadedLight;
      this.shade(this.#shown_light.toLight, [...cells], diameter);
    }
    if (this.#moved) this.#castModels();
    const place = this.takePlace();
    const bodies = this.#bodies(place.bodies);
    const sandy = this.#radius > 0;
    bodies.forEach((body, i) => this.#colliders[i].set({ ...k_still, ...body }));
    this.#nozzles.forEach((nozzle, i) => this.#emitters[i].set(nozzle));
    this.#input.set({
      ...this.#shadows.fields,
      ...place.fields,
      time_step: seconds,
      collider_count: sandy ? bodies.length : 0,
      emitter_count: sandy && this.#unmade === 0 ? this.#nozzles.length : 0,
    });
    this.sand.sandglass_scene_frame(this.#scene, this.#input, this.#report);
    return this.drawn(this.#shown_light);
  }
  // What the sand collides with.
  #bodies(place) {
    const { SANDGLASS_SHAPE_HALF_SPACE, SANDGLASS_SHAPE_FIELD, SANDGLASS_SHAPE_SPHERE } = constants;
    const floor = { shape: SANDGLASS_SHAPE_HALF_SPACE, position: this.#options.origin };
    const bodies = [floor, ...place, ...this.#hands.bodies];
    for (const [id, { position, rotation, field }] of this.#models)
      if (field) bodies.push({ shape: SANDGLASS_SHAPE_FIELD, position, rotation, field, id });
    for (const { position, radius, velocity = [0, 0, 0] } of this.#balls) {
      const size = [radius, 0, 0];
      bodies.push({ shape: SANDGLASS_SHAPE_SPHERE, position, size, linear_velocity: velocity });
    }
    return bodies;
  }

  // What changed since the call before. Its arrays are views of the module's memory, valid until the next call.
  drawn(light) {
    const { time, sand } = this.#report;
    const sandy = this.#radius > 0;
    const out = {
      light,
      ...this.#shadows.drawn(this.#casting, sandy),
      behind: this.#shadows.behind,
      fieldsLeft: this.#unmade,
      milliseconds: time.elapsed_ns / 1e6,
      particles: sand.particles,
    };
    if (!sandy) return out;
    return { ...out, skin: this.#changes.take(), streams: this.#streams(), radius: this.#radius };
  }
  #streams() {
    return this.#nozzles.slice(0, k_streams).map(({ position, rotation, radius, speed }) => {
      const down = matrixOf(position, rotation)
        .slice(4, 7)
        .map((c) => -c);
      return { nozzle: [...position, radius], way: [...down, speed] };
    });
  }
}
