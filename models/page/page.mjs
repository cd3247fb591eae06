// The page: an hourglass that a finger turns over, a table with a chair and sand that a finger pours and pushes, and what
// a frame takes.
import { load, constants } from "./sandglass.mjs";
import { SandScene, addPoints, fieldBytes, unpacked } from "./scene.mjs";
import { Camera, Painter } from "./painter.mjs";
import { sandBlock } from "./sand_block.mjs";
import { Stage, fieldOf, matrixOf } from "./stage.mjs";
import { meshReader, standing, smoothed } from "./mesh_file.mjs";
import { Turning, k_neck, funnelMesh, glassMesh, hourglassField, sandBelow, woodMesh } from "./hourglass.mjs";
import { RoomParts, lightOfSky } from "./room_light.mjs";
import { gravityOfAngles, gravityOfScreen, downOnScreen, screenPose, tableOfRoom, cellsOfTable } from "./tilt.mjs";
import { fromLink } from "./link.mjs";
import { Pace } from "./pace.mjs";
import { fixedRun, Pauses, stagesOf } from "./measure.mjs";
import { listen, play } from "./controls.mjs";
import { by, say, counted } from "./elements.mjs";
import { k_module, k_mesh_module, k_block_module, k_scene } from "./data.mjs";

const k_step = k_scene.frame_step, k_radius = k_scene.granular.particle_radius;
const k_pour = { radius: 4 * k_radius, speed: 0.8 };
const k_layer = 16;          // particles of a layer of that nozzle at most
const k_pour_height = 0.3;   // metres above what is touched
const k_hand = 6 * k_radius; // radius of the sphere that pushes
const k_hand_speed = 1;      // m/s at most, so that a finger that jumps does not hit the sand
const k_box = 0.64;          // half the side of the sand's shadow, metres
const k_threads_at_most = 4; // a phone's fast cores
const k_frames_at_once = 12;  // where pictures take long; after a pause the sand does not run on to catch up
const k_mesh_height = 0.22;  // metres, of a mesh that becomes sand; how wide it is at most; how far above the mark it begins to fall
const k_mesh_width = 0.5;
const k_mesh_above = 0.05;
const k_mesh_particles = 1000;  // about the most of one mesh, so that it finds room beside what the scene and a finger pour
const k_objects = 4;          // that are put on the table, at most
const k_paint = [0.35, 0.33, 0.30], k_metal = [0.95, 0.93, 0.88];  // of objects: albedo, and what metal reflects
const k_object_triangles = 100000;  // of all of them
const k_object_spacing = 0.5 * k_radius;  // of the field that sand collides with
const k_casts = { shadow: false, collide: false };  // as a model is added: shadows come when it is shown, and fields are the page's
const k_recorded_at_most = 18000;  // frames: five minutes
const k_glass_radius = 0.0035, k_glass_particles = 1320;  // of the sand in the hourglass: its lower half is full
const k_glass_least = 500;   // on a slow device
const k_glass_ms = 16;       // of all work of a frame that is worth it; levels of quality save half of it
const k_trials = 8, k_trial_ms = 120;  // frames at most, and how long others follow, before the first picture is drawn
const k_in_time = 0.9;       // of the time that was asked for: not slow motion
const k_late = 10;           // times as long as a picture's frames a picture takes, at most
const k_flow_frames = 16;    // over which that is seen
const k_turn_fit = 0.24;     // so much wider is what must fit on a tall screen while the glass turns
const k_wood = [0.16, 0.075, 0.035], k_brass = [0.86, 0.62, 0.28], k_glass_friction = 0.3;
const k_views = { glass: { target: [0, 0.105, 0], distance: 0.68, elevation: 0.16, fit: 0.5 }, table: { target: [0.01, 0.15, 0.03], distance: 1.32, elevation: 0.42, fit: 0.66 } };
const k_emitter_fields = ["position", "rotation", "radius", "speed"];
const k_collider_fields = ["shape", "position", "rotation", "size", "linear_velocity"];
const k_tip_least = 0.05;    // m/s^2: sensors tremble by less
const k_rest_ms = 250;       // so often the page looks whether something has changed
const k_seconds_at_most = 1; // of frame times, that the numbers are means of
const k_sky_light = lightOfSky([1.05, 0.97, 0.84], [0.288, 0.32, 0.376], [0.176, 0.152, 0.128]);  // of the sliders
const k_main_light = 0.02;   // the least share of the floor's light that tells where it comes from
// Glass walls, passed once the table was tipped, so that no sand slides away for ever. From the middle, metres.
const k_wall = 0.62;
const k_walls = [[0, 0, -1, 1], [0, 0, 1, 1], [1, 0, 0, 1], [-1, 0, 0, 1]].map((rotation, i) => ({ shape: constants.SANDGLASS_SHAPE_HALF_SPACE,
  position: [i === 0 ? -k_wall : i === 1 ? k_wall : 0, 0, i === 2 ? -k_wall : i === 3 ? k_wall : 0], rotation, size: [1, 1, 1] }));

class Page {
  constructor(sand) {
    this.sand = sand;
    this.painter = new Painter(by("view"), k_radius), this.camera = new Camera(), this.pace = new Pace();
    this.tool = "glass", this.mark = [0.26, 0, 0.16], this.at = null, this.pushing = null, this.time = 0, this.owed = 0;
    this.spent = [], this.recorded = [], this.added = [], this.objects = [];
    this.denied = 0, this.saidFull = false, this.flow = this.least = this.late = 1, this.before = this.waited = 0;
    this.gravity = [...k_scene.gravity], this.given = [...k_scene.gravity], this.tipped = false;
    this.stage = new Stage(sand, { origin: [0, 0, 0], half: k_box, budget: 0 }), this.room = new RoomParts(this.stage);
    this.stage.newPile();
    this.stands = { glass: this.makeGlass() };
    this.show("glass");
    this.fitDevice();
    this.opens = !matchMedia("(prefers-reduced-motion: reduce)").matches;  // once its sand is seen
  }

  newScene() {
    const more = 1 + k_walls.length + k_objects;
    return new SandScene(this.sand, k_scene, { clock: true, colliders: more, changes: { emitter_capacity: 2, collider_capacity: k_scene.colliders.length + more } });
  }

  makeTable() {
    const stand = { scene: this.newScene(), standing: [], drawn: [] }, funnel = funnelMesh();
    this.painter.funnel = this.painter.item(funnel.vertices, funnel.indices, null, k_brass, funnel.normals);
    this.stage.newCast(k_object_triangles);
    for (const { field, position, rotation } of k_scene.colliders) {
      if (!field) continue;
      const model = matrixOf(position, rotation), vertices = unpacked(field.vertices, Float32Array), indices = unpacked(field.indices, Uint32Array);
      stand.drawn.push(this.painter.item(vertices, indices, model, [0.17, 0.30, 0.43]));
      stand.standing.push(this.stage.addModel({ positions: vertices, indices, position, rotation }, k_casts));
    }
    return Object.assign(stand, { skin: this.newSkin(stand.scene, 0) });
  }

  // The hourglass stands still with all its sand below until it is turned over.
  makeGlass() {
    const { sand, painter } = this, flat = { rotation: [0, 0, 0, 1], size: [1, 1, 1] }, below = sandBelow(k_glass_particles, k_glass_radius);
    const file = { name: "hourglass", gravity: k_scene.gravity, frame_step: k_step, emitters: [], particles: below.subarray(0, 3 * k_glass_least),
      granular: { ...k_scene.granular, particle_radius: k_glass_radius, particle_capacity: k_glass_particles, grain_radius: 0, substep_max: 0, substep_min: 0, collider_capacity: 2,
        static_friction: k_glass_friction, kinetic_friction: k_glass_friction },
      colliders: [{ shape: constants.SANDGLASS_SHAPE_HALF_SPACE, position: [0, 0, 0], ...flat }, { shape: constants.SANDGLASS_SHAPE_FIELD, position: [0, 0, 0], ...flat, field: hourglassField(sand) }] };
    this.turning = new Turning();
    const scene = new SandScene(sand, file, { clock: true }), wood = woodMesh(), glass = glassMesh(), pose = this.turning.pose(), model = matrixOf(pose.position, pose.rotation);
    return { scene, below, full: below.length / 3, skin: this.newSkin(scene, 1), drawn: [painter.item(wood.vertices, wood.indices, model, k_wood)],
      standing: [this.stage.addModel({ positions: wood.vertices, indices: wood.indices, ...pose }, k_casts)],
      glass: { ...painter.mesh(glass.vertices, glass.indices, glass.normals), model } };
  }

  // Few frames at rest tell how much sand this device simulates in time.
  fitDevice() {
    const { full } = this.stands.glass, since = performance.now();
    let fits = 0;  // of particles
    for (let i = 0; i < 1 || (i < k_trials && fits < full && performance.now() - since < k_trial_ms); ++i) fits = Math.max(fits, k_glass_least * k_glass_ms / this.settle());
    if (fits > k_glass_least) this.fillGlass(fits);
  }

  // A frame of the glass at rest with all the work that its sand and their skin need, so that it is seen. Gives milliseconds.
  settle() {
    const { scene, turning } = this, { pile_shadow, cast_count } = scene.input, still = [0, 0, 0];
    scene.colliders[1].set({ ...turning.pose(), linear_velocity: still, angular_velocity: still });
    scene.input.set({ pile_shadow: 0, cast_count: 0 });
    const ms = scene.frame(k_step).time.elapsed_ns / 1e6;
    scene.input.set({ pile_shadow, cast_count });
    return ms;
  }

  // Puts so many particles into the lower half, at rest.
  fillGlass(count) {
    this.scene.file.particles = this.stands.glass.below.subarray(0, 3 * Math.max(k_glass_least, Math.round(count)));
    this.refill();
  }
  get inGlass() { return this.stands.glass.scene.file.particles.length / 3; }

  newSkin({ desc }, capped) { return this.stage.make("sandglass_skin", { capped }, desc.granular); }

  // Puts the hourglass or the table before the camera; the other one stands still.
  show(name) {
    const { sand, painter, camera, stage } = this, stand = this.stands[name] ??= this.makeTable();
    if (this.stand === stand) return;
    if (this.stand) this.stand.drawn = painter.objects, this.stand.view = { ...camera };
    this.stand = stand, this.scene = stand.scene, this.skin = stand.skin;
    painter.objects = stand.drawn, painter.glass = stand.glass ?? null, painter.sand.radius = stand.scene.desc.granular.particle_radius;
    painter.sand.clear(), stage.take(this.skin, painter.sand.radius), stage.pour();
    Object.assign(camera, stand.view ?? k_views[name]);
    this.scene.input.set({ skin: this.skin, pile_shadow: stage.pile, casts: stage.castList, cast_count: painter.wall ? 2 : 1 });
    sand.sandglass_pile_shadow_refresh(stage.pile);
    this.at = this.pushing = null, this.owed = 0, this.flow = this.least = 1, this.opens = false;
    this.setGravity(this.scene, this.given = [...this.gravity]);
    this.castAll(), this.setLight();
  }
  // Whether anything may change: if not, no frame runs and nothing is drawn.
  wake() { this.pace.wake(), this.ask?.(); }
  restless() {
    const { scene, pace, at, watching, tipping, turning, stage: { nozzles } } = this;
    return pace.touched || this.opens || at !== null || !!watching || !!tipping || turning.turns || (nozzles.length > 0 && this.onTable) || scene.report.sand.awake > 0 || this.behind !== 0;
  }
  // Where sand ran down in slow motion although less is drawn, the next turn is of less sand.
  turnOver() {
    if (!this.turning.turns && this.scene.report.sand.awake === 0 && this.least < k_in_time) this.fillGlass(this.least * this.inGlass);
    this.opens = false, this.least = 1;
    this.turning.begin(this.turnAxis()), this.wake();
  }
  get onTable() { return this.stand === this.stands.table; }
  get skinMesh() { return this.stage.changes.mesh; }
  turnAxis() { const { away } = this.camera.axes(), flat = Math.hypot(away[0], away[2]); return [away[0] / flat, 0, away[2] / flat]; }

  // What is shown casts.
  castAll() {
    this.wake();
    const { stage, stands, objects } = this, all = [...Object.values(stands), { standing: objects.map(({ number }) => number) }];
    for (const stand of all) for (const number of stand.standing) stage.models.get(number).shadow = stand === this.stand || (this.onTable && !stand.scene);
    stage.castModels();
  }

  // Objects cast on a wall, too: `pose` is a column-major matrix whose y is the wall's normal, `low` and `high` its extent in x
  // and z; null: there is none.
  setWall(pose, low, high) {
    const { stage, painter, scene } = this, [x, y, z, at] = [0, 4, 8, 12].map((k) => [...pose?.slice(k, k + 3) ?? []]);
    if (!pose) {
      scene.input.cast_count = 1, painter.wall = null;
      return;
    }
    stage.setWall({ x, y, z, at, low, high });
    scene.input.cast_count = 2;
    const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0), back = [x, y, z].map((axis) => -dot(axis, at));
    const on = new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, ...back, 1]);
    painter.wall = { model: new Float32Array(pose), on, plane: [...y, back[1]], x, y, at };
  }

  // The light that is drawn: the device's in augmented reality, the camera's, or that of the sliders.
  setLight(seconds = 0) {
    this.wake();
    const { sand, stage, painter } = this;
    const azimuth = by("azimuth").value * Math.PI / 180, polar = by("polar").value * Math.PI / 180, known = stage.room_light.valid === 1;
    const slid = { ...k_sky_light, toLight: [Math.sin(polar) * Math.cos(azimuth), Math.cos(polar), Math.sin(polar) * Math.sin(azimuth)] };
    const seen = known && (this.watching || this.real) ? stage.fade(Math.max(0, seconds)) : null;
    const light = (this.real && this.deviceLight) || seen || slid;
    if (light === seen && this.watching) this.turnWithTheTable(light);
    else painter.tableOfRoom = [1, 0, 0, 0, 1, 0, 0, 0, 1];
    painter.light = light, this.lit = light !== slid;
    if (!seen && painter.roomKnown) painter.roomKnown = 0, this.room.images = 0;
    // Where the light from all around comes from: the sky of the sliders is even.
    const cells = seen ? Float32Array.from(stage.light.ambient_cells) : new Float32Array(constants.SANDGLASS_LIGHT_CELLS).fill(1);
    stage.shade(light.toLight, cellsOfTable(cells, painter.tableOfRoom), light === seen ? stage.light.main_angular_diameter : 0);
    if (!painter.wall) return;
    const table = this.real?.table ?? [0, 0, 0], { at, y, x } = painter.wall;
    sand.floats(stage.words, cells.length).set(seen ? this.room.cellsOfWall(at.map((c, i) => c + table[i]), y, x) : cells);
    sand.sandglass_cast_set_cells(stage.casts[1], stage.words);
  }

  // A table that is tipped with the picture turns in the room, and the room's light about it.
  turnWithTheTable(light) {
    const known = this.tipping && this.level && this.device;
    const m = known ? tableOfRoom(downOnScreen(this.device, screen.orientation?.angle), this.level, this.camera.axes(), this.turnedBy()) : [1, 0, 0, 0, 1, 0, 0, 0, 1];
    this.painter.tableOfRoom = m;
    const [x, y, z] = light.toLight;
    light.toLight = [0, 1, 2].map((i) => x * m[i] + y * m[3 + i] + z * m[6 + i]);
  }

  // Radians that the device was turned about the vertical since it was first heard of.
  turnedBy() { return (this.device.alpha - this.deviceStart.alpha) * Math.PI / 180; }

  // The camera's next image into the room's light.
  watch(now) {
    const image = this.watching?.next(now);
    if (!image) return;
    const known = this.device && downOnScreen(this.device, screen.orientation?.angle);
    const pose = screenPose(known, this.camera.axes(), known ? this.turnedBy() : 0);
    if (this.watching.towardsUser) for (const k of [0, 1, 2, 8, 9, 10]) pose[k] = -pose[k];
    this.stage.see(image, { orientation: this.room.orientationOf(pose), ms: now });
  }

  // How the device is held now. It is level as it was when `tipping` began.
  hold(event) {
    this.device = event, this.deviceStart ??= event;
    if (!this.tipping) return;
    const down = downOnScreen(event, screen.orientation?.angle), gravity = gravityOfScreen(down, this.level ??= down, this.camera.axes());
    if (Math.hypot(...gravity.map((x, k) => x - this.gravity[k])) > k_tip_least) this.gravity = gravity;
  }
  tipByAngles(right, near) { this.gravity = gravityOfAngles(right, near); }

  setGravity(scene, gravity) {
    const { sand, stage: { words } } = this;
    sand.floats(words, 3).set(gravity);
    sand.sandglass_scene_set_gravity(scene.handle, words);
  }

  // What stands in the way besides the scene's own colliders; gives how many there are in all.
  placeWalls(scene, objects = this.objects) {
    let first = k_scene.colliders.length;
    for (const { field, at } of objects.filter((object) => object.field))
      scene.colliders[first++].set({ shape: constants.SANDGLASS_SHAPE_FIELD, position: at, rotation: [0, 0, 0, 1], size: [1, 1, 1], field });
    if (!this.tipped) return first;
    k_walls.forEach((wall, i) => scene.colliders[first + i].set(wall));
    return first + k_walls.length;
  }

  // The emitters and colliders of a frame, by what the finger or the keys do.
  act(first) {
    const { scene, at } = this;
    if (!this.onTable) return this.turn();
    let emitters = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : scene.pourAsTheFileSays(), colliders = first;
    if (at && this.tool === "pour") scene.emitters[emitters++].set({ ...k_pour, position: [at[0], at[1] + k_pour_height, at[2]], rotation: [0, 0, 0, 1] });
    if (at && this.tool === "push") {
      const wanted = [at[0], 0.6 * k_hand, at[2]], before = this.pushing ?? wanted, moved = wanted.map((x, i) => x - before[i]);
      const share = Math.min(1, k_hand_speed * k_step / Math.max(1e-9, Math.hypot(...moved)));
      this.pushing = before.map((x, i) => x + share * moved[i]);
      scene.colliders[colliders++].set({ shape: constants.SANDGLASS_SHAPE_SPHERE, position: this.pushing, rotation: [0, 0, 0, 1],
        size: [k_hand, 0, 0], linear_velocity: moved.map((x) => share * x / k_step) });
    } else this.pushing = null;
    scene.input.collider_count = colliders;
    this.stage.pour(...scene.emitters.slice(0, emitters).map(({ position, radius, speed }) => ({ position: [...position], radius, speed })));
    return emitters;
  }

  // The hourglass as it stands at the frame's end. It casts where it is.
  turn() {
    const { scene, turning, stand } = this, turned = turning.turns;
    scene.colliders[1].set({ ...turning.advance(k_step, this.flow, this.late) });
    scene.input.collider_count = 2;
    this.stage.pour(...turning.turns ? [] : [k_neck]);
    if (turned) this.placeGlass();
    return 0;
  }
  placeGlass() {
    const { position, rotation } = this.turning.pose(), { drawn: [wood], glass, standing: [number] } = this.stands.glass;
    wood.model = glass.model = matrixOf(position, rotation);
    this.stage.move(number, position, rotation), this.castAll();
  }

  // What the frame was given and what it executed, so that it can be run again to the bit. Work units of shadows are left
  // out: sand does not depend on them.
  record(emitters, plan, first) {
    const { scene, added } = this;
    this.added = [];
    if (!this.onTable || this.recorded.length >= k_recorded_at_most) return;
    const picked = (view, names) => Object.fromEntries(names.map((name) => [name, typeof view[name] === "number" ? view[name] : [...view[name]]]));
    const runs = plan.runs.slice(0, plan.run_count).filter(({ stage }) => stage !== constants.SANDGLASS_STAGE_SHADOW && stage !== constants.SANDGLASS_STAGE_SKIN);
    this.recorded.push({ emitters: scene.emitters.slice(0, emitters).map((emitter) => picked(emitter, k_emitter_fields)),
      colliders: scene.colliders.slice(first, scene.input.collider_count).map((collider) => picked(collider, k_collider_fields)),
      level: plan.level, runs: runs.map(({ stage, units }) => [stage, units]), ...(this.tipped ? { gravity: this.given, tipped: true } : {}), ...(added.length ? { added } : {}) });
    if (this.recorded.length === k_recorded_at_most) this.recordedHash = scene.hash();
  }

  recording() {
    return { sandglass: "recording", scene: k_scene.name, step: k_step, frames: this.recorded, hash: this.recordedHash ?? this.scene.hash() };
  }

  // Runs a recording in a new scene, which then replaces the present one. Throws where it does not end as it did.
  async play(recording, shown) {
    if (recording?.sandglass !== "recording" || recording.scene !== k_scene.name || !Array.isArray(recording.frames))
      throw new Error("The file is no recording of this page. Choose one that it saved.");
    this.show("table");
    const { sand } = this, scene = this.newScene(), plan = sand.make("sandglass_plan"), pauses = new Pauses();
    const before = { given: this.given, tipped: this.tipped, objects: this.objects };
    this.given = [...k_scene.gravity], this.tipped = false, this.objects = [];
    try {
      for (const [i, frame] of recording.frames.entries()) {
        this.playFrame(scene, frame, plan, recording.step);
        await pauses.perhaps(shown, i / recording.frames.length);
      }
    } catch (error) {
      scene.destroy(), sand.free(plan);
      this.dropObjects();
      Object.assign(this, before);
      this.showObjects();
      throw new Error(error.message.startsWith("sandglass") || error.constructor === Error ? error.message : "The recording is damaged, so it cannot be played. Ask for it again.");
    }
    scene.input.plan = 0;
    const hash = scene.hash(), { skin, pile_shadow, casts, cast_count } = this.scene.input, after = this.objects;
    scene.input.set({ skin, pile_shadow, casts, cast_count });
    this.scene.destroy(), this.stand.scene = scene;
    this.objects = before.objects, this.dropObjects();
    this.objects = after, this.showObjects();
    sand.free(plan);
    this.scene = scene, this.recorded = [...recording.frames], this.recordedHash = undefined, this.added = [], this.denied = scene.report.sand.denied_particles;
    sand.sandglass_pile_shadow_refresh(this.stage.pile), sand.sandglass_skin_refresh(this.skin);
    if (hash !== recording.hash) throw new Error(`The recording ends in ${hash} here and in ${recording.hash} where it was made. Please report this.`);
    return hash;
  }

  playFrame(scene, { emitters, colliders, level, runs, gravity, tipped, added }, plan, step) {
    for (const { particles, vertices, indices, at, metal } of added ?? []) {
      if (vertices) {
        const object = this.objectOf({ vertices: Float32Array.from(vertices), indices: Uint32Array.from(indices) }, at, metal);
        this.objects.push(Object.assign(object, { field: this.fieldOf(object) }));
      } else addPoints(this.sand, scene.handle, { positions: Float32Array.from(particles) });
    }
    if (gravity && gravity.some((x, k) => x !== this.given[k])) this.setGravity(scene, this.given = gravity);
    this.tipped = tipped === true;
    const first = this.placeWalls(scene);
    emitters.forEach((emitter, k) => scene.emitters[k].set(emitter));
    colliders.forEach((collider, k) => scene.colliders[first + k].set(collider));
    scene.input.collider_count = first + colliders.length;
    plan.level = level, plan.run_count = runs.length;
    plan.runs.slice(0, runs.length).forEach((run, k) => run.set({ stage: runs[k][0], units: runs[k][1] }));
    scene.input.plan = plan;
    scene.frame(step, 0, emitters.length);
  }

  // Moves on by so many seconds of wall time: up to twelve frames. Says whether it did.
  advance(seconds) {
    const { scene } = this;
    this.owed = Math.min(this.owed + seconds, k_frames_at_once * k_step), this.waited += seconds;
    if (this.owed < k_step) return false;
    // Where pictures take longer than so many frames, one after the other, each frame has as much more time.
    this.late = Math.max(1, Math.min(k_late, Math.min(this.waited, this.before) / (k_frames_at_once * k_step))), this.before = this.waited, this.waited = 0;
    const budget = Number(by("budget").value) * this.late;
    while (this.owed >= k_step) {
      this.owed -= k_step;
      scene.input.output_lag = 0;
      if (this.gravity.some((x, k) => x !== this.given[k])) this.setGravity(scene, this.given = [...this.gravity]), this.tipped = true;
      const before = scene.report.time.simulated, first = this.onTable ? this.placeWalls(scene) : 0, emitters = this.act(first), report = scene.frame(k_step, budget, emitters);
      this.flow += (Math.min(1, (report.time.simulated - before) / k_step) - this.flow) / k_flow_frames, this.least = Math.min(this.least, this.flow);
      this.record(emitters, report.plan, first);
      this.tellFull(report.sand);
      this.spent.push({ ms: report.time.elapsed_ns / 1e6 / this.late, stages: report.stages.map((stage) => stage.elapsed_ns / 1e6 / this.late) });
      if (this.spent.length > k_seconds_at_most / k_step) this.spent.shift();
    }
    return true;
  }

  // A finger pours and nothing comes: said once, until it is lifted.
  tellFull({ denied_particles }) {
    const full = this.particles() + k_layer > this.scene.desc.granular.particle_capacity;  // or else something is in the way
    const nothing = full && this.at !== null && this.tool === "pour" && denied_particles > this.denied;
    if (nothing && !this.saidFull) say(`${this.full()}. Press "Start again" to clear it.`);
    this.saidFull = this.at !== null && (this.saidFull || nothing), this.denied = denied_particles;
  }

  // What was added since the last frame is in no report yet.
  particles() { return this.scene.report.sand.particles + this.added.reduce((sum, { particles = [] }) => sum + particles.length / 3, 0); }
  full() { return `The table is full: ${counted(this.particles())} of ${counted(this.scene.desc.granular.particle_capacity)} particles are there`; }

  // What changed of shadows and sand, and where it is poured from. Shadows of the sliders' light are not quite dark.
  takeDrawn() {
    const { stage, painter } = this, umbra = this.lit ? 1 : 0.9, drawn = stage.drawn(painter.light);
    drawn.pileOpacity *= umbra, drawn.shadowOpacity *= umbra;
    painter.take(drawn);
    painter.funnels = this.onTable ? drawn.streams.map(({ nozzle: [x, y, z] }) => matrixOf([x, y, z], [0, 0, 0, 1])) : [];
    const metal = this.objects.find((object) => object.metal);
    if (metal && (this.watching || this.real)) this.room.reflect(metal.at.map((x, k) => x + (this.real?.table?.[k] ?? 0) + (k === 1 ? k_mesh_height / 2 : 0)), k_mesh_height / 2, painter);
  }

  draw() {
    const { painter, pace, stage, skinMesh } = this;
    this.takeDrawn();
    this.behind = stage.behind + skinMesh.frames_behind;
    painter.sand.share = pace.now.loose;
    if (!this.onTable) this.camera.fit = k_views.glass.fit + k_turn_fit * this.turning.wide;
    painter.draw(this.camera, pace.now);
    if (this.opens && skinMesh.index_count + skinMesh.flying_count + skinMesh.lying_count > 0) this.turnOver();
  }

  tell() {
    const { report } = this.scene, of = this.spent.length || 1;
    const mean = (pick) => this.spent.reduce((sum, frame) => sum + pick(frame), 0) / of;
    const budget = Number(by("budget").value), ms = mean((frame) => frame.ms), bar = by("bar");
    const slow = this.flow < k_in_time ? "Slower: this device is busy" : !this.onTable && this.inGlass < this.stands.glass.full ? "Less sand: this device is slow" : "";
    by("short").textContent = slow || `Sand: ${ms.toFixed(1)} of ${budget} ms a frame`, by("short").className = slow ? "slow" : ms > budget + 1 ? "late" : "";
    if (!by("more").open) return;
    bar.setAttribute("aria-valuenow", Math.round(100 * ms / budget));
    const parts = stagesOf(this.sand).map(({ name, colour }, i) => [name, colour, mean((frame) => frame.stages[i])]).filter(([, , part]) => part > 0.005);
    bar.replaceChildren(...parts.map(([, colour, part]) => Object.assign(document.createElement("span"),
      { style: `width:${100 * part / Math.max(budget, ms)}%;background:${colour}` })));
    const row = (name, value, colour) => {
      const term = document.createElement("dt");
      if (colour) term.append(Object.assign(document.createElement("i"), { style: `background:${colour}` }));
      term.append(name);
      return [term, Object.assign(document.createElement("dd"), { textContent: value })];
    };
    by("numbers").replaceChildren(...[...parts.map(([name, colour, part]) => row(name, `${part.toFixed(2)} ms`, colour)),
      row("quality level", `${report.level} ${this.sand.sandglass_level_name(report.level)}`), row("time debt", `${report.time.debt.toFixed(2)} s`),
      row("particles", counted(report.sand.particles)), row("triangles", counted(this.skinMesh.index_count / 3)), row("drawn", this.pace.said), ...this.tellLight(row)].flat());
  }

  // What the camera knows of the room's light, and in augmented reality how far from the device's it is.
  tellLight(row) {
    if (this.stage.room_light.valid !== 1 || !(this.watching || this.real)) return [];
    const { seen, main_share, main_direction } = this.stage.room_light, percent = (share) => `${Math.round(100 * share)} %`;
    const rows = [row("room seen", percent(seen)), row("main light", percent(main_share))];
    if (!this.real || !this.deviceLight || main_share < k_main_light) return rows;
    const cosine = this.deviceLight.toLight.reduce((sum, x, k) => sum + x * main_direction[k], 0);
    return [...rows, row("from the device's light", `${Math.round(Math.acos(Math.min(1, cosine)) * 180 / Math.PI)}°`)];
  }

  again() {
    this.wake();
    if (this.onTable) this.dropObjects();
    else this.turning = new Turning(), this.opens = false, this.placeGlass();
    this.refill();
    if (this.onTable) this.recorded = [], this.added = [], this.recordedHash = undefined;
    this.given = [...k_scene.gravity], this.tipped = false;
  }

  refill() {
    const { sand, scene } = this;
    sand.sandglass_scene_reset(scene.handle);
    sand.sandglass_pile_shadow_refresh(this.stage.pile), sand.sandglass_skin_refresh(this.skin);
    scene.frames = 0, scene.fill();
    scene.report.sand.set({ particles: 0, denied_particles: 0 }), scene.report.time.simulated = 0, this.denied = 0;
    if (!this.onTable) this.settle();
  }

  // The reader of mesh files; it is compiled when the first one comes.
  readMesh() { return this.meshReader ??= inflated(k_mesh_module).then(meshReader); }

  // A mesh as an object at the mark: it casts at once, and sand collides with it when its field is made, a frame later.
  addObject(read, metal = false) {
    const mesh = standing(read, k_mesh_height, k_mesh_width), triangles = this.objects.reduce((sum, { indices }) => sum + indices.length / 3, mesh.indices.length / 3);
    if (this.objects.length === k_objects) throw new Error(`There are ${k_objects} objects on the table. Press "Start again" to clear it.`);
    if (triangles > k_object_triangles - 1000) throw new Error(`The mesh has too many triangles: ${counted(triangles)} of ${counted(k_object_triangles)}. Choose a coarser one.`);
    const object = this.objectOf(mesh, [...this.mark], metal);
    this.objects.push(object);
    this.showObjects();
    requestAnimationFrame(() => setTimeout(() => this.giveField(object)));  // once it was seen
    return mesh.indices.length / 3;
  }

  giveField(object) {
    const { vertices, indices, at, metal } = object;
    if (!this.objects.includes(object)) return;
    try { object.field = this.fieldOf(object); } catch (error) { say(`Sand goes through the object: ${error.message}`); return; }
    this.added.push({ vertices: [...vertices], indices: [...indices], at, metal });
  }

  objectOf({ vertices, indices }, at, metal) {
    const pose = { position: at, rotation: [0, 0, 0, 1] }, model = matrixOf(at, pose.rotation);
    return { vertices, indices, at, metal, model, field: 0, number: this.stage.addModel({ positions: vertices, indices, ...pose }, k_casts) };
  }

  fieldOf({ vertices, indices }) { return this.sand.put(fieldOf(this.sand, { positions: vertices, indices }, k_object_spacing)); }

  showObjects() {
    for (const object of this.objects) object.drawn ??= this.drawnObject(object);
    this.castAll();
  }

  drawnObject({ vertices, indices, model, metal }) {
    if (!metal) return this.painter.add(vertices, indices, model, k_paint);
    const { corners, normals } = smoothed(vertices, indices);
    return this.painter.add(corners, Uint32Array.from({ length: indices.length }, (_, i) => i), model, k_metal, normals);
  }

  dropObjects() {
    const gone = this.objects;
    this.objects = [], this.wake();
    for (const { drawn, field, number } of gone) {
      if (drawn) this.painter.remove(drawn);
      this.stage.remove(number), this.sand.free(field);
    }
  }

  // A mesh as sand: its volume on the library's lattice, above the mark. One that takes too much sand is made smaller.
  addMesh(read) {
    const mesh = standing(read, k_mesh_height, k_mesh_width);
    let particles = this.filled(mesh);
    if (particles.length === 0) throw new Error("The mesh is too thin to be filled with sand. Choose one with a volume.");
    const smaller = Math.cbrt(3 * k_mesh_particles / particles.length);
    if (smaller < 1) particles = this.filled({ ...mesh, vertices: mesh.vertices.map((x) => x * smaller) });
    const count = particles.length / 3;
    if (count > this.scene.desc.granular.particle_capacity - this.particles())
      throw new Error(`${this.full()}, and the mesh needs ${counted(count)}. Press "Start again", then drop it again.`);
    for (let i = 0; i < particles.length; i += 3) particles[i] += this.mark[0], particles[i + 1] += k_mesh_above, particles[i + 2] += this.mark[2];
    addPoints(this.sand, this.scene.handle, { positions: particles });
    this.wake();
    this.added.push({ particles: [...particles] });
    return count;
  }

  // The particles that fill a mesh. What it takes of the module's memory it gives back, also where the library refuses.
  filled({ vertices, indices }) {
    const { sand } = this, blocks = [], keep = (block) => { blocks.push(block); return block; };
    try {
      const mesh = keep(sand.make("sandglass_mesh", { vertices: keep(sand.put(vertices)), vertex_count: vertices.length / 3, indices: keep(sand.put(indices)), triangle_count: indices.length / 3 }));
      const desc = keep(sand.make("sandglass_sample_desc")), out = keep(sand.allocate(8)), word = () => new Uint32Array(sand.memory.buffer, out, 1)[0];
      sand.sandglass_sample_desc_default(desc);
      sand.sandglass_mesh_bounds(mesh, desc.bounds_min, desc.bounds_max);
      desc.set({ method: constants.SANDGLASS_SAMPLE_LATTICE, distance: 2.02 * k_radius, inside: sand.pointer("sandglass_mesh_inside_test"),
        inside_user: keep(sand.create("sandglass_mesh_inside", mesh, constants.SANDGLASS_INSIDE_WINDING)) });
      sand.sandglass_sample_capacity(desc, out);
      const capacity = word();
      sand.sandglass_sample_bytes(desc, capacity, out);
      const scratch = word(), block = keep(sand.allocate(scratch)), points = keep(sand.allocate(12 * capacity));
      sand.sandglass_sample_points(desc, block, scratch, points, capacity, out);
      return sand.floats(points, 3 * word()).slice();
    } finally {
      for (const block of blocks) sand.free(block);
    }
  }

  place(event) {
    const box = by("view").getBoundingClientRect();
    const at = this.camera.onPlane((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, box.width / box.height);
    return at && Math.hypot(...at) < 1.2 ? at : null;
  }
}

const inflated = (text) => new Response(new Blob([unpacked(text, Uint8Array)]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();

// The library, with a pool where browsers let memory be shared, on a page that is cross-origin isolated, and its module lies
// beside the page. No results depend on it. What fails with threads may do without.
async function loaded() {
  const threads = globalThis.crossOriginIsolated ? Math.min(k_threads_at_most, navigator.hardwareConcurrency) : 1;
  const pooled = threads > 1 ? await load("sandglass-threads.wasm", { threads }).catch(() => null) : null;
  return pooled ?? load(await inflated(k_module));
}

// What takes seconds, made in a worker of this script once a picture is drawn; where there is none, it is made here.
function letHelp(page) {
  const script = document.querySelector("script[type=module]").textContent.replaceAll("import.meta.url", "location.href"), url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  const worker = new Worker(url);
  worker.onmessage = ({ data: { block, fields } }) => {
    if (block) page.painter.setBlock(block), page.wake();
    else fields.forEach((made, i) => { if (made) k_scene.colliders[i].field.made ??= made; }), worker.terminate();
  };
  worker.onerror = async () => { page.painter.setBlock(await sandBlock(await inflated(k_block_module))), page.wake(); };
}
async function help() {
  postMessage({ block: await sandBlock(await inflated(k_block_module)) });
  const sand = await load(await inflated(k_module));
  postMessage({ fields: k_scene.colliders.map(({ field }) => field && fieldBytes(sand, field)) });
}

async function begin() {
  const page = new Page(await loaded());
  listen(page);
  window.sandglassPage = { page, fixedRun: (frames) => fixedRun(page.sand, frames) };  // for the page's test
  let before = performance.now(), told = 0, drew = false, asked = 0, sandTook = 0, drawn = 0;
  const frame = (now) => {
    const seconds = Math.max(0, now - before) / 1e3, runs = !page.measuring && !page.real && page.restless(), start = performance.now();
    if (runs) {
      page.watch(now);
      if (page.watching) page.setLight(seconds);
      const moved = drawn > 0 && page.advance(seconds), took = performance.now() - start;
      // Nothing is drawn twice: where pictures take long, a browser asks for the next one before it has shown the last.
      if (moved || !drew || page.pace.touched || page.watching) {
        if (drew) page.pace.drew(now - drawn - sandTook);
        page.draw();
        if (drawn === 0) letHelp(page);
        drawn = now, sandTook = took;
      }
    }
    drew = runs, before = now;
    if (now - told > 250) page.tell(), told = now;
    if (page.scene.report.sand.particles > 0) document.documentElement.dataset.sand ??= Math.round(performance.now());
    asked = runs ? requestAnimationFrame(frame) : setTimeout(() => frame(performance.now()), k_rest_ms);
  };
  page.ask = () => { if (!drew) clearTimeout(asked), cancelAnimationFrame(asked), asked = requestAnimationFrame(frame), drew = true, before = performance.now(); };
  // What was hidden goes on where it was, and no picture took so long.
  document.addEventListener("visibilitychange", () => { before = performance.now(), drew = false; });
  asked = requestAnimationFrame(frame);
  const recording = await fromLink(location.hash);
  if (recording) await play(page, recording);
}

if (typeof document === "undefined") help();
else begin().catch((error) => say(error.message));
