// The page: an hourglass that a finger turns over, a table with a chair and sand that a finger pours and pushes, and what
// a frame takes.
import { constants } from "./sandglass.mjs";
import { Camera, Painter } from "./painter.mjs";
import { Stage } from "./stage.mjs";
import { matrixOf } from "./mesh_field.mjs";
import { Turning, hourglassMade, k_neck } from "./hourglass.mjs";
import { RoomParts, lightOfSky } from "./room_light.mjs";
import { gravityOfAngles, gravityOfScreen, downOnScreen, screenPose, tableOfRoom, cellsOfTable } from "./tilt.mjs";
import { fromLink } from "./link.mjs";
import { Pace } from "./pace.mjs";
import { fixedRun } from "./measure.mjs";
import { listen, play } from "./controls.mjs";
import { by, say, counted } from "./elements.mjs";
import { fitting, k_glass_min, k_walls, makeGlass, makeTable } from "./stands.mjs";
import { dropObjects, k_mesh_height } from "./objects.mjs";
import { playRecording, record, recordingOf } from "./recording.mjs";
import { slowMotion, tell } from "./readout.mjs";
import { help, inflated, letHelp, loaded, loadedMeshReader } from "./loaded.mjs";
import { k_scene } from "./data.mjs";

const k_step = k_scene.frame_step;
const k_radius = k_scene.granular.particle_radius;
const k_pour = { radius: 4 * k_radius, speed: 0.8 };
const k_layer = 16; // particles of a layer of that nozzle at most
const k_pour_height = 0.3; // metres above what is touched
const k_reach = 1.2; // metres from the middle that are touched
const k_hand = 6 * k_radius; // radius of the sphere that pushes
const k_hand_speed = 1; // m/s at most, so that a finger that jumps does not hit the sand
const k_box = 0.64; // half the side of the sand's shadow, metres
const k_frames_at_once = 12; // where pictures take long; after a pause the sand does not run on to catch up
const k_late = 10; // times as long as a picture's frames a picture takes, at most
const k_flow_frames = 16; // over which it is seen how much of the time is simulated
const k_turn_fit = 0.24; // so much wider is what must fit on a tall screen while the glass turns
const k_views = {
  glass: { target: [0, 0.105, 0], distance: 0.68, elevation: 0.16, fit: 0.5 },
  table: { target: [0.01, 0.15, 0.03], distance: 1.32, elevation: 0.42, fit: 0.66 },
};
const k_tip_min = 0.05; // m/s^2: sensors tremble by less
const k_rest_ms = 250; // so often the page looks whether something has changed
const k_told_ms = 250; // so often numbers are written
const k_seconds_at_most = 1; // of frame times, that the numbers are means of
const k_sky_light = lightOfSky([1.05, 0.97, 0.84], [0.288, 0.32, 0.376], [0.176, 0.152, 0.128]); // of the sliders
const k_sky_umbra = 0.9; // of the sliders' light, which is not quite dark
const k_quick_ms = 120; // in which what is shown is made; a device that takes longer fits less than the least sand
const k_level = [1, 0, 0, 0, 1, 0, 0, 0, 1]; // the room's axes are the table's

const lessMotion = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
const radiansOf = (id) => (by(id).value * Math.PI) / 180;

export class Page {
  // `hourglass`: of hourglassMade.
  constructor(sand, painter, hourglass) {
    const began = performance.now();
    this.sand = sand;
    this.hourglass = hourglass;
    this.words = sand.allocate(4 * 3);
    this.skinMesh = sand.make("sandglass_skin_mesh");
    this.painter = painter;
    this.camera = new Camera();
    this.pace = new Pace();
    this.tool = "glass";
    this.mark = [0.26, 0, 0.16];
    this.at = null; // what a finger touches
    this.pushing = null;
    this.pouring = false;
    this.time = 0;
    this.owed = 0;
    this.spent = [];
    this.recorded = [];
    this.added = [];
    this.objects = [];
    this.denied = 0;
    this.saidFull = false;
    this.flow = 1; // the share of time that was simulated lately
    this.slowest = 1;
    this.late = 1;
    this.before = 0;
    this.waited = 0;
    this.gravity = [...k_scene.gravity];
    this.given = [...k_scene.gravity];
    this.tipped = false;
    this.stage = new Stage(sand, { origin: [0, 0, 0], half: k_box, budget: 0, reflections: true });
    this.room = new RoomParts(this.stage);
    this.turning = new Turning();
    this.stands = { glass: makeGlass(sand, this.stage, painter, this.turning.pose(), hourglass) };
    this.show("glass");
    // Where that took long there is time for the least sand, which is loose in the first picture.
    if (performance.now() - began < k_quick_ms) this.fitDevice();
    else this.settle(0);
    this.opens = !lessMotion(); // once its sand is seen
  }

  fitDevice() {
    const fits = fitting(this.stands.glass.full, () => this.settle());
    if (fits > k_glass_min) this.fillGlass(fits);
  }

  // A frame of the glass at rest, without a budget with all the work that its sand and their skin need, so that it is seen. Gives
  // milliseconds.
  settle(budget) {
    const { scene, turning } = this;
    const { pile_shadow, cast_count } = scene.input;
    const still = [0, 0, 0];
    scene.colliders[1].set({ ...turning.pose(), linear_velocity: still, angular_velocity: still });
    scene.input.set({ pile_shadow: 0, cast_count: 0 });
    const ms = scene.frame(k_step, budget).time.elapsed_ns / 1e6;
    scene.input.set({ pile_shadow, cast_count });
    return ms;
  }

  // Puts so many particles into the lower half, at rest.
  fillGlass(count) {
    const particles = Math.max(k_glass_min, Math.round(count));
    this.scene.file.particles = this.stands.glass.below.subarray(0, 3 * particles);
    this.refill();
  }
  get inGlass() {
    return this.stands.glass.scene.file.particles.length / 3;
  }

  // Puts the hourglass or the table before the camera; the other one stands still.
  show(name) {
    const { sand, painter, camera, stage, hourglass } = this;
    const stand = (this.stands[name] ??= makeTable(sand, stage, painter, hourglass));
    if (this.stand === stand) return;
    if (this.stand) {
      this.stand.drawn = painter.objects;
      this.stand.view = { ...camera };
    }
    this.stand = stand;
    this.scene = stand.scene;
    painter.objects = stand.drawn;
    painter.glass = stand.glass ?? null;
    painter.sand.radius = stand.scene.desc.granular.particle_radius;
    painter.sand.clear();
    stage.showSand(stand.skin, painter.sand.radius);
    stage.pour();
    Object.assign(camera, stand.view ?? k_views[name]);
    this.scene.input.set(stage.frameFields);
    this.at = null;
    this.pushing = null;
    this.pouring = false;
    this.owed = 0;
    this.flow = 1;
    this.slowest = 1;
    this.opens = false;
    this.setGravity(this.scene, [...this.gravity]);
    this.castAll();
    this.setLight();
  }
  // Whether anything may change: if not, no frame runs and nothing is drawn.
  wake() {
    this.pace.wake();
    this.ask?.();
  }
  restless() {
    const { scene, pace, at, watching, tipping, turning } = this;
    const touched = pace.touched || this.opens || at !== null || Boolean(watching) || Boolean(tipping);
    const moves = turning.turns || (this.pouring && this.onTable) || scene.report.sand.awake > 0;
    return touched || moves || this.behind !== 0;
  }
  // Where sand ran down in slow motion although less is drawn, the next turn is of less sand.
  turnOver() {
    const { turning, scene } = this;
    if (!turning.turns && scene.report.sand.awake === 0 && slowMotion(this.slowest))
      this.fillGlass(this.slowest * this.inGlass);
    this.opens = false;
    this.slowest = 1;
    turning.begin(this.turnAxis());
    this.wake();
  }
  get onTable() {
    return this.stand === this.stands.table;
  }
  turnAxis() {
    const { away } = this.camera.axes();
    const flat = Math.hypot(away[0], away[2]);
    return [away[0] / flat, 0, away[2] / flat];
  }

  // What is shown casts.
  castAll() {
    this.wake();
    const objects = this.onTable ? this.objects.map(({ number }) => number) : [];
    this.stage.castOnly(...this.stand.standing, ...objects);
  }

  // Objects cast on a wall, too: `pose` is a column-major matrix whose y is the wall's normal, `low` and `high` its extent in x
  // and z; null: there is none.
  setWall(pose, low, high) {
    const { stage, painter, scene } = this;
    const [x, y, z, at] = pose ? [0, 4, 8, 12].map((k) => [...pose.slice(k, k + 3)]) : [];
    stage.setWall(pose && { x, y, z, at, low, high });
    scene.input.set(stage.frameFields);
    painter.wall = null;
    if (!pose) return;
    const back = [x, y, z].map((axis) => -axis.reduce((sum, v, i) => sum + v * at[i], 0));
    const on = [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, ...back, 1];
    painter.wall = { model: new Float32Array(pose), on: new Float32Array(on), plane: [...y, back[1]], x, y, at };
  }

  // The light that is drawn: the device's in augmented reality, the camera's, or that of the sliders.
  setLight(seconds = 0) {
    this.wake();
    const { stage, painter } = this;
    const known = Boolean(this.watching || this.real) && stage.roomLight.valid === 1;
    const seen = known ? stage.fade(Math.max(0, seconds)) : null;
    const own = this.real && this.deviceLight;
    const light = own || seen || this.slidLight();
    painter.tableOfRoom = k_level;
    if (light === seen && this.watching) this.turnWithTheTable(light);
    painter.light = light;
    this.lit = Boolean(own || seen);
    if (!seen && painter.roomKnown) {
      painter.roomKnown = 0;
      this.room.images = 0;
    }
    // Where the light from all around comes from: the sky of the sliders is even.
    const even = new Float32Array(constants.SANDGLASS_LIGHT_CELLS).fill(1);
    const cells = seen ? Float32Array.from(stage.fadedLight.ambient_cells) : even;
    const diameter = light === seen ? stage.fadedLight.main_angular_diameter : 0;
    const { tableOfRoom } = painter;
    stage.shade(light.toLight, tableOfRoom === k_level ? cells : cellsOfTable(cells, tableOfRoom), diameter);
    if (painter.wall) stage.shadeWall(seen ? this.cellsOfWall() : cells);
  }
  slidLight() {
    const azimuth = radiansOf("azimuth");
    const polar = radiansOf("polar");
    const flat = Math.sin(polar);
    return { ...k_sky_light, toLight: [flat * Math.cos(azimuth), Math.cos(polar), flat * Math.sin(azimuth)] };
  }
  cellsOfWall() {
    const { at, y, x } = this.painter.wall;
    const table = this.real?.table ?? [0, 0, 0];
    const there = at.map((c, i) => c + table[i]);
    return this.room.cellsOfWall(there, y, x);
  }

  // A table that is tipped with the picture turns in the room, and the room's light about it.
  turnWithTheTable(light) {
    if (!(this.tipping && this.level && this.device)) return;
    const down = downOnScreen(this.device, screen.orientation?.angle);
    const m = tableOfRoom(down, this.level, this.camera.axes(), this.turnedBy());
    const [x, y, z] = light.toLight;
    this.painter.tableOfRoom = m;
    light.toLight = [0, 1, 2].map((i) => x * m[i] + y * m[3 + i] + z * m[6 + i]);
  }

  // Radians that the device was turned about the vertical since it was first heard of.
  turnedBy() {
    return ((this.device.alpha - this.deviceStart.alpha) * Math.PI) / 180;
  }

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
    this.device = event;
    this.deviceStart ??= event;
    if (!this.tipping) return;
    const down = downOnScreen(event, screen.orientation?.angle);
    this.level ??= down;
    const gravity = gravityOfScreen(down, this.level, this.camera.axes());
    if (Math.hypot(...gravity.map((x, k) => x - this.gravity[k])) > k_tip_min) this.gravity = gravity;
  }
  tipByAngles(right, near) {
    this.gravity = gravityOfAngles(right, near);
  }

  setGravity(scene, gravity) {
    this.given = gravity;
    this.sand.floats(this.words, 3).set(gravity);
    this.sand.sandglass_scene_set_gravity(scene.handle, this.words);
  }

  // What stands in the way besides the scene's own colliders; gives how many there are in all.
  placeWalls(scene) {
    const still = { rotation: [0, 0, 0, 1], size: [1, 1, 1] };
    let first = k_scene.colliders.length;
    for (const { field, at } of this.objects)
      if (field)
        scene.colliders[first++].set({ shape: constants.SANDGLASS_SHAPE_FIELD, position: at, ...still, field });
    if (this.real) {
      const { fields, bodies } = this.stage.takePlace();
      scene.input.set(fields);
      for (const body of bodies) scene.colliders[first++].set({ ...still, field: 0, ...body });
    }
    if (!this.tipped) return first;
    k_walls.forEach((wall, i) => scene.colliders[first + i].set(wall));
    return first + k_walls.length;
  }

  // The emitters and colliders of a frame, by what the finger or the keys do.
  act(first) {
    const { scene, at, stage } = this;
    if (!this.onTable) return this.turn();
    let emitters = lessMotion() ? 0 : scene.pourAsTheFileSays();
    let colliders = first;
    if (at && this.tool === "pour") {
      const position = [at[0], at[1] + k_pour_height, at[2]];
      scene.emitters[emitters++].set({ ...k_pour, position, rotation: [0, 0, 0, 1] });
    }
    if (at && this.tool === "push") scene.colliders[colliders++].set(this.pushedBall(at));
    else this.pushing = null;
    scene.input.collider_count = colliders;
    const open = scene.emitters.slice(0, emitters);
    this.pouring = emitters > 0;
    stage.pour(...open.map(({ position, radius, speed }) => ({ position: [...position], radius, speed })));
    return emitters;
  }
  // What a finger moves through the sand.
  pushedBall(at) {
    const wanted = [at[0], 0.6 * k_hand, at[2]];
    const before = this.pushing ?? wanted;
    const moved = wanted.map((x, i) => x - before[i]);
    const share = Math.min(1, (k_hand_speed * k_step) / Math.max(1e-9, Math.hypot(...moved)));
    this.pushing = before.map((x, i) => x + share * moved[i]);
    return {
      shape: constants.SANDGLASS_SHAPE_SPHERE,
      position: this.pushing,
      rotation: [0, 0, 0, 1],
      size: [k_hand, 0, 0],
      linear_velocity: moved.map((x) => (share * x) / k_step),
    };
  }

  // The hourglass as it stands at the frame's end. It casts where it is.
  turn() {
    const { scene, turning } = this;
    const turned = turning.turns;
    scene.colliders[1].set({ ...turning.advance(k_step, this.flow, this.late) });
    scene.input.collider_count = 2;
    this.stage.pour(...(turning.turns ? [] : [k_neck]));
    if (turned) this.placeGlass();
    return 0;
  }
  placeGlass() {
    const { position, rotation } = this.turning.pose();
    const { drawn, glass, standing } = this.stands.glass;
    drawn[0].model = matrixOf(position, rotation);
    glass.model = drawn[0].model;
    this.stage.move(standing[0], position, rotation);
    this.castAll();
  }

  // Moves on by so many seconds of wall time: up to twelve frames. Says whether it did.
  advance(seconds) {
    this.owed = Math.min(this.owed + seconds, k_frames_at_once * k_step);
    this.waited += seconds;
    if (this.owed < k_step) return false;
    // Where pictures take longer than so many frames, one after the other, each frame has as much more time.
    const pictures = Math.min(this.waited, this.before) / (k_frames_at_once * k_step);
    this.late = Math.max(1, Math.min(k_late, pictures));
    this.before = this.waited;
    this.waited = 0;
    const budget = Number(by("budget").value) * this.late;
    while (this.owed >= k_step) {
      this.owed -= k_step;
      this.runFrame(budget);
    }
    return true;
  }
  runFrame(budget) {
    const { scene } = this;
    scene.input.output_lag = 0;
    if (this.gravity.some((x, k) => x !== this.given[k])) {
      this.setGravity(scene, [...this.gravity]);
      this.tipped = true;
    }
    const before = scene.report.time.simulated;
    const first = this.onTable ? this.placeWalls(scene) : 0;
    const emitters = this.act(first);
    const report = scene.frame(k_step, budget, emitters);
    const flow = Math.min(1, (report.time.simulated - before) / k_step);
    this.flow += (flow - this.flow) / k_flow_frames;
    this.slowest = Math.min(this.slowest, this.flow);
    record(this, emitters, report.plan, first);
    this.tellFull(report.sand);
    const ms = (ns) => ns / 1e6 / this.late;
    this.spent.push({ ms: ms(report.time.elapsed_ns), stages: report.stages.map((one) => ms(one.elapsed_ns)) });
    if (this.spent.length > k_seconds_at_most / k_step) this.spent.shift();
  }

  // A finger pours and nothing comes: said once, until it is lifted.
  tellFull({ denied_particles }) {
    const full = this.particles() + k_layer > this.scene.desc.granular.particle_capacity; // or else something is in the way
    const nothing = full && this.at !== null && this.tool === "pour" && denied_particles > this.denied;
    if (nothing && !this.saidFull) say(`${this.full()}. Press "Start again" to clear it.`);
    this.saidFull = this.at !== null && (this.saidFull || nothing);
    this.denied = denied_particles;
  }

  // What was added since the last frame is in no report yet.
  particles() {
    const added = this.added.reduce((sum, { particles = [] }) => sum + particles.length / 3, 0);
    return this.scene.report.sand.particles + added;
  }
  full() {
    const most = counted(this.scene.desc.granular.particle_capacity);
    return `The table is full: ${counted(this.particles())} of ${most} particles are there`;
  }

  // What changed of shadows and sand, and where it is poured from. Shadows of the sliders' light are not quite dark.
  takeDrawn() {
    const { stage, painter, sand } = this;
    const umbra = this.lit ? 1 : k_sky_umbra;
    const drawn = stage.drawn(painter.light);
    drawn.pileOpacity *= umbra;
    drawn.shadowOpacity *= umbra;
    sand.sandglass_skin_get_mesh(this.stand.skin, this.skinMesh);
    this.behind = drawn.behind + this.skinMesh.frames_behind;
    painter.take(drawn);
    const streams = this.onTable ? drawn.streams : [];
    painter.funnels = streams.map(({ nozzle: [x, y, z] }) => matrixOf([x, y, z], [0, 0, 0, 1]));
    const metal = this.objects.find((object) => object.metal);
    if (metal && (this.watching || this.real)) this.reflectAt(metal.at);
  }
  reflectAt(at) {
    const table = this.real?.table ?? [0, 0, 0];
    const half = k_mesh_height / 2;
    const middle = at.map((x, k) => x + table[k] + (k === 1 ? half : 0));
    this.room.reflect(middle, half, this.painter);
  }

  draw() {
    const { painter, pace, skinMesh } = this;
    this.takeDrawn();
    painter.sand.share = pace.now.loose;
    if (!this.onTable) this.camera.fit = k_views.glass.fit + k_turn_fit * this.turning.wide;
    painter.draw(this.camera, pace.now);
    const seen = skinMesh.index_count + skinMesh.flying_count + skinMesh.lying_count > 0;
    if (this.opens && seen) this.turnOver();
  }

  recording() {
    return recordingOf(this);
  }
  play(recording, shown) {
    return playRecording(this, recording, shown);
  }

  again() {
    this.wake();
    if (this.onTable) dropObjects(this);
    else {
      this.turning = new Turning();
      this.opens = false;
      this.placeGlass();
    }
    this.refill();
    if (this.onTable) {
      this.recorded = [];
      this.added = [];
      this.recordedHash = undefined;
    }
    this.given = [...k_scene.gravity];
    this.tipped = false;
  }

  refill() {
    const { sand, scene, stage } = this;
    sand.sandglass_scene_reset(scene.handle);
    stage.refresh();
    scene.frames = 0;
    scene.fill();
    scene.report.sand.set({ particles: 0, denied_particles: 0 });
    scene.report.time.simulated = 0;
    this.denied = 0;
    if (!this.onTable) this.settle();
  }

  readMesh() {
    this.meshReader ??= loadedMeshReader();
    return this.meshReader;
  }

  // The place of the table that is touched, or null.
  place(event) {
    const box = by("view").getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width;
    const y = (event.clientY - box.top) / box.height;
    const at = this.camera.onPlane(x, y, box.width / box.height);
    return at && Math.hypot(...at) < k_reach ? at : null;
  }
}

// The page's frames, for as long as something may change.
class Frames {
  #page;
  #before = performance.now();
  #told = 0;
  #drew = false;
  #asked = 0;
  #sand_took = 0;
  #drawn = 0; // when a picture was drawn

  constructor(page) {
    this.#page = page;
    page.ask = () => this.#ask();
    // What was hidden goes on where it was, and no picture took so long.
    document.addEventListener("visibilitychange", () => {
      this.#before = performance.now();
      this.#drew = false;
    });
    this.#next(true);
  }
  #next(runs) {
    const frame = (now) => this.#frame(now);
    this.#asked = runs ? requestAnimationFrame(frame) : setTimeout(() => frame(performance.now()), k_rest_ms);
  }
  #ask() {
    if (this.#drew) return;
    clearTimeout(this.#asked);
    cancelAnimationFrame(this.#asked);
    this.#next(true);
    this.#drew = true;
    this.#before = performance.now();
  }
  #frame(now) {
    const page = this.#page;
    const seconds = Math.max(0, now - this.#before) / 1e3;
    const runs = !page.measuring && !page.real && page.restless();
    if (runs) this.#run(now, seconds);
    this.#drew = runs;
    this.#before = now;
    if (now - this.#told > k_told_ms) {
      tell(page);
      this.#told = now;
    }
    if (page.scene.report.sand.particles > 0) document.documentElement.dataset.sand ??= Math.round(performance.now());
    this.#next(runs);
  }
  #run(now, seconds) {
    const page = this.#page;
    const start = performance.now();
    page.watch(now);
    if (page.watching) page.setLight(seconds);
    const moved = this.#drawn > 0 && page.advance(seconds);
    const took = performance.now() - start;
    // Nothing is drawn twice: where pictures take long, a browser asks for the next one before it has shown the last.
    if (!(moved || !this.#drew || page.pace.touched || page.watching)) return;
    if (this.#drew) page.pace.drew(now - this.#drawn - this.#sand_took);
    page.draw();
    if (this.#drawn === 0) setTimeout(() => letHelp(page)); // the picture is shown first
    this.#drawn = now;
    this.#sand_took = took;
  }
}

async function begin() {
  const painter = new Painter(by("view"), k_radius); // first: its compilers run beside all else
  const [sand, hourglass] = await Promise.all([loaded(), inflated("hourglass")]);
  const page = new Page(sand, painter, hourglassMade(hourglass));
  listen(page);
  window.sandglassPage = { page, fixedRun: (frames) => fixedRun(page.sand, frames) }; // for the page's test
  new Frames(page);
  const recording = await fromLink(location.hash);
  if (recording) await play(page, recording);
}

if (typeof document === "undefined") help();
else begin().catch((error) => say(error.message));
