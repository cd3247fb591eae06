// The page: a table with a chair, sand that a finger pours and pushes, and what a frame takes.
import { load, constants } from "./sandglass.mjs";
import { SandScene, unpacked } from "./scene.mjs";
import { Camera, Painter } from "./painter.mjs";
import { readObj, standing } from "./obj.mjs";
import { k_module, k_scene, k_chair_shadow } from "./data.mjs";

const k_stages = [["granular", "sand", "#ffb454"], ["lighting", "light", "#f4f1a2"], ["shadow", "shadow", "#8fb8ff"],
  ["refine", "grains", "#e07b39"], ["output", "output", "#9ad6a0"]];
const k_step = k_scene.frame_step, k_radius = k_scene.granular.particle_radius;
const k_pour = { radius: 4 * k_radius, speed: 0.8, grains_per_particle: 16 };
const k_pour_height = 0.3;   // metres above what is touched
const k_hand = 6 * k_radius; // radius of the sphere that pushes
const k_hand_speed = 1;      // m/s at most, so that a finger that jumps does not hit the sand
const k_box = 0.64;          // half the side of the sand's shadow, metres
const k_frames_at_once = 2;  // after a pause the sand does not run on to catch up
const k_mesh_height = 0.22;  // metres, of a mesh that becomes sand, and how far above the mark it begins to fall
const k_mesh_above = 0.05;
const k_pause_ms = 100;      // of the fixed run, before the page is drawn
const k_recorded_at_most = 18000;  // frames: five minutes
const k_emitter_fields = ["position", "rotation", "radius", "speed", "grains_per_particle"];
const k_collider_fields = ["shape", "position", "rotation", "size", "linear_velocity"];
const k_seconds_at_most = 1; // of frame times, that the numbers are means of

const by = (id) => document.getElementById(id);
const say = (sentence) => { by("says").textContent = sentence; };

class Page {
  constructor(sand) {
    this.sand = sand;
    this.painter = new Painter(by("view")), this.camera = new Camera();
    this.tool = "pour", this.mark = [0.26, 0, 0.16], this.at = null, this.pushing = null, this.time = 0, this.owed = 0;
    this.spent = [], this.recorded = [], this.added = [];
    this.startScene();
    this.makeShadows();
    this.setLight();
  }

  newScene() { return new SandScene(this.sand, k_scene, { clock: true, colliders: 1, changes: { emitter_capacity: 2, collider_capacity: 3 } }); }

  startScene() {
    this.scene = this.newScene();
    for (const { field, position, rotation } of k_scene.colliders) {
      if (!field) continue;
      const [x, y, z, w] = rotation, [px, py, pz] = position;
      const model = new Float32Array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0, 2 * (x * y - w * z),
        1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0, 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0, px, py, pz, 1]);
      this.painter.add(unpacked(field.vertices, Float32Array), unpacked(field.indices, Uint32Array), model, [0.17, 0.30, 0.43]);
    }
  }

  makeShadows() {
    const { sand, scene, painter } = this, { position, rotation, height } = k_scene.colliders.find((collider) => collider.field);
    this.direction = sand.put(new Float32Array(3));
    const pile = sand.make("sandglass_pile_shadow_desc");
    sand.sandglass_pile_shadow_desc_default(pile);
    pile.set({ low: [-k_box, -k_box], high: [k_box, k_box], texels: 128 });
    this.pile = sand.create("sandglass_pile_shadow", pile), this.pileTexture = sand.make("sandglass_pile_shadow_texture");
    painter.pileShadow.box = [-k_box, -k_box, 0.5 / k_box, 0.5 / k_box];
    const bytes = unpacked(k_chair_shadow, Uint8Array), desc = sand.make("sandglass_shadow_desc"), info = sand.make("sandglass_shadow_info");
    sand.sandglass_shadow_desc_default(desc);
    desc.asset = sand.put(bytes), desc.asset_bytes = bytes.length;
    sand.sandglass_shadow_inspect(desc.asset, bytes.length, info);
    this.object = sand.create("sandglass_shadow", desc), this.objectTexture = sand.make("sandglass_shadow_texture");
    sand.free(desc.asset);
    // The file is of a mesh of its own size; the chair stands turned about y.
    this.yaw = 2 * Math.atan2(rotation[1], rotation[3]), this.shadowScale = height / info.height, this.shadowOrigin = [...info.origin];
    const [c, s] = [Math.cos(this.yaw), Math.sin(this.yaw)];
    Object.assign(painter.objectShadow, { turn: [c, s, -s, c], at: [position[0], position[2]] });
    scene.input.pile_shadow = this.pile, scene.input.shadows = sand.put(new Uint32Array([this.object])), scene.input.shadow_count = 1;
  }

  setLight() {
    const azimuth = by("azimuth").value * Math.PI / 180, polar = by("polar").value * Math.PI / 180;
    const d = this.toLight = [Math.sin(polar) * Math.cos(azimuth), Math.cos(polar), Math.sin(polar) * Math.sin(azimuth)];
    const { sand, direction } = this, [c, s] = [Math.cos(this.yaw), Math.sin(this.yaw)];
    sand.floats(direction, 3).set(d);
    sand.sandglass_pile_shadow_set_light(this.pile, direction);
    sand.floats(direction, 3).set([c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]]);
    sand.sandglass_shadow_set_light(this.object, 0, direction, 1);
  }

  // The emitters and colliders of a frame, by what the finger or the keys do.
  act() {
    const { scene, at } = this;
    let emitters = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : scene.pourAsTheFileSays(), colliders = k_scene.colliders.length;
    if (at && this.tool === "pour") scene.emitters[emitters++].set({ ...k_pour, position: [at[0], at[1] + k_pour_height, at[2]], rotation: [0, 0, 0, 1] });
    if (at && this.tool === "push") {
      const wanted = [at[0], 0.6 * k_hand, at[2]], before = this.pushing ?? wanted, moved = wanted.map((x, i) => x - before[i]);
      const share = Math.min(1, k_hand_speed * k_step / Math.max(1e-9, Math.hypot(...moved)));
      this.pushing = before.map((x, i) => x + share * moved[i]);
      scene.colliders[colliders++].set({ shape: constants.SANDGLASS_SHAPE_SPHERE, position: this.pushing, rotation: [0, 0, 0, 1],
        size: [k_hand, 0, 0], linear_velocity: moved.map((x) => share * x / k_step) });
    } else this.pushing = null;
    scene.input.collider_count = colliders;
    return emitters;
  }

  // What the frame was given and what it executed, so that it can be run again to the bit. Work units of shadows are left
  // out: sand does not depend on them.
  record(emitters, plan) {
    if (this.recorded.length >= k_recorded_at_most) return;
    const picked = (view, names) => Object.fromEntries(names.map((name) => [name, typeof view[name] === "number" ? view[name] : [...view[name]]]));
    const { scene, added } = this, runs = plan.runs.slice(0, plan.run_count).filter(({ stage }) => stage !== constants.SANDGLASS_STAGE_SHADOW);
    this.recorded.push({ emitters: scene.emitters.slice(0, emitters).map((emitter) => picked(emitter, k_emitter_fields)),
      colliders: scene.colliders.slice(k_scene.colliders.length, scene.input.collider_count).map((collider) => picked(collider, k_collider_fields)),
      level: plan.level, runs: runs.map(({ stage, units }) => [stage, units]), ...(added.length ? { added } : {}) });
    this.added = [];
    if (this.recorded.length === k_recorded_at_most) this.recordedHash = scene.hash();
  }

  recording() {
    return { sandglass: "recording", scene: k_scene.name, step: k_step, frames: this.recorded, hash: this.recordedHash ?? this.scene.hash() };
  }

  // Runs a recording in a new scene, which then replaces the present one. Throws where it does not end as it did.
  async play(recording, shown) {
    if (recording?.sandglass !== "recording" || recording.scene !== k_scene.name || !Array.isArray(recording.frames))
      throw new Error("The file is no recording of this page. Choose one that it saved.");
    const { sand } = this, scene = this.newScene(), plan = sand.make("sandglass_plan");
    let paused = performance.now();
    for (const [i, { emitters, colliders, level, runs, added }] of recording.frames.entries()) {
      for (const { particles, grains } of added ?? []) this.addSand(scene, Float32Array.from(particles), Float32Array.from(grains));
      emitters.forEach((emitter, k) => scene.emitters[k].set(emitter));
      colliders.forEach((collider, k) => scene.colliders[k_scene.colliders.length + k].set(collider));
      scene.input.collider_count = k_scene.colliders.length + colliders.length;
      plan.level = level, plan.run_count = runs.length;
      plan.runs.slice(0, runs.length).forEach((run, k) => run.set({ stage: runs[k][0], units: runs[k][1] }));
      scene.input.plan = plan;
      scene.frame(recording.step, 0, emitters.length);
      if (performance.now() - paused > k_pause_ms) {
        shown(i / recording.frames.length);
        await new Promise((go) => setTimeout(go));
        paused = performance.now();
      }
    }
    scene.input.plan = 0;
    const hash = scene.hash(), { pile_shadow, shadows, shadow_count } = this.scene.input;
    scene.input.set({ pile_shadow, shadows, shadow_count });
    this.scene.destroy();
    sand.free(plan);
    this.scene = scene, this.recorded = [...recording.frames], this.recordedHash = undefined;
    sand.sandglass_pile_shadow_refresh(this.pile);
    if (hash !== recording.hash) throw new Error(`The recording ends in ${hash} here and in ${recording.hash} where it was made. Please report this.`);
    return hash;
  }

  // Moves on by so many seconds of wall time: zero, one or two frames.
  advance(seconds) {
    const { scene } = this, budget = Number(by("budget").value);
    this.owed = Math.min(this.owed + seconds, k_frames_at_once * k_step);
    while (this.owed >= k_step) {
      this.owed -= k_step;
      scene.input.output_lag = 0;
      const emitters = this.act(), report = scene.frame(k_step, budget, emitters);
      this.record(emitters, report.plan);
      this.spent.push({ ms: report.elapsed_ns / 1e6, stages: report.stages.map((stage) => stage.elapsed_ns / 1e6), budget });
      if (this.spent.length > k_seconds_at_most / k_step) this.spent.shift();
    }
  }

  draw() {
    const { sand, scene, painter } = this, count = scene.report.grain_numbers;
    const pile = this.pileTexture, object = this.objectTexture;
    sand.sandglass_pile_shadow_get_texture(this.pile, pile);
    painter.pileShadow.opacity = pile.valid ? 0.9 * pile.opacity : 0;
    if (pile.valid) {
      painter.upload(painter.pile, pile.texels, sand.bytes(pile.coverage, pile.texels ** 2));
      painter.upload(painter.onSand, pile.texels, sand.bytes(pile.on_sand, pile.texels ** 2));
    }
    sand.sandglass_shadow_get_texture(this.object, 0, object);
    painter.objectShadow.opacity = object.valid ? 0.9 * object.opacity : 0;
    if (object.valid) {
      painter.upload(painter.object, 256, sand.bytes(object.coverage, 256 * 256));
      const [low, high] = [object.low, object.high].map((corner) => [0, 1].map((i) => (corner[i] - this.shadowOrigin[2 * i]) * this.shadowScale));
      painter.objectShadow.box = [...low, 1 / (high[0] - low[0]), 1 / (high[1] - low[1])];
    }
    painter.draw(this.camera, this.toLight, sand.floats(scene.grains, 4 * count), count, scene.desc.granular.grain_radius);
  }

  tell() {
    const { report } = this.scene, of = this.spent.length || 1;
    const mean = (pick) => this.spent.reduce((sum, frame) => sum + pick(frame), 0) / of;
    const budget = Number(by("budget").value), ms = mean((frame) => frame.ms), bar = by("bar");
    bar.setAttribute("aria-valuenow", Math.round(100 * ms / budget));
    const parts = k_stages.map(([, name, colour], i) => [name, colour, mean((frame) => frame.stages[i])]).filter(([, , part]) => part > 0.005);
    bar.replaceChildren(...parts.map(([, colour, part]) => Object.assign(document.createElement("span"),
      { style: `width:${100 * part / Math.max(budget, ms)}%;background:${colour}` })));
    const row = (name, value, colour) => {
      const term = document.createElement("dt");
      if (colour) term.append(Object.assign(document.createElement("i"), { style: `background:${colour}` }));
      term.append(name);
      return [term, Object.assign(document.createElement("dd"), { textContent: value })];
    };
    by("short").textContent = `${ms.toFixed(1)} of ${budget} ms`;
    by("numbers").replaceChildren(...[...parts.map(([name, colour, part]) => row(name, `${part.toFixed(2)} ms`, colour)),
      row("quality level", `${report.level} ${this.sand.sandglass_level_name(report.level)}`), row("time debt", `${report.time_debt.toFixed(2)} s`),
      row("grains", `${report.grains} of ${report.particles} particles`)].flat());
  }

  again() {
    this.sand.sandglass_scene_reset(this.scene.handle);
    this.sand.sandglass_pile_shadow_refresh(this.pile);
    this.scene.frames = 0, this.scene.fill();
    this.recorded = [], this.added = [], this.recordedHash = undefined;
  }

  // A mesh as sand: its volume on the library's lattice, above the mark.
  addMesh(text) {
    const { sand, scene } = this, { vertices, indices } = standing(readObj(text), k_mesh_height);
    const mesh = sand.make("sandglass_mesh", { vertices: sand.put(vertices), vertex_count: vertices.length / 3, indices: sand.put(indices), triangle_count: indices.length / 3 });
    const low = sand.allocate(12), high = sand.allocate(12), out = sand.allocate(8);
    sand.sandglass_mesh_bounds(mesh, low, high);
    const inside = sand.create("sandglass_mesh_inside", mesh, constants.SANDGLASS_INSIDE_WINDING);
    const test = sand.pointer("sandglass_mesh_inside_test"), word = () => new Uint32Array(sand.memory.buffer, out, 1)[0];
    sand.sandglass_sample_lattice_capacity(low, high, 2.02 * k_radius, out);
    const capacity = word();
    sand.sandglass_sample_lattice_bytes(low, high, 2.02 * k_radius, out);
    const scratch = word(), block = sand.allocate(scratch), points = sand.allocate(12 * capacity);
    sand.sandglass_sample_lattice(low, high, 2.02 * k_radius, test, inside, 0, block, scratch, points, capacity, out);
    const particles = sand.floats(points, 3 * word()).slice();
    for (const used of [mesh.vertices, mesh.indices, mesh, low, high, out, block, points]) sand.free(used);
    sand.destroy(inside);
    if (particles.length === 0) throw new Error("The mesh is too thin to be filled with sand. Choose one with a volume.");
    // Grains at random places within the particles, by a generator with a fixed seed.
    const grains = new Float32Array(particles.length * k_pour.grains_per_particle);
    let seed = 1;
    const random = () => (seed = (seed * 1664525 + 1013904223) >>> 0) / 2 ** 32 - 0.5;
    for (let i = 0; i < particles.length; i += 3) particles[i] += this.mark[0], particles[i + 1] += k_mesh_above, particles[i + 2] += this.mark[2];
    for (let i = 0; i < grains.length; ++i) grains[i] = particles[3 * Math.floor(i / 3 / k_pour.grains_per_particle) + i % 3] + 2 * k_radius * random();
    this.addSand(scene, particles, grains);
    this.added.push({ particles: [...particles], grains: [...grains] });
    return particles.length / 3;
  }

  addSand(scene, particles, grains) {
    const { sand } = this, p = sand.put(particles), g = sand.put(grains);
    try { sand.sandglass_granular_add(scene.handle, p, 0, particles.length / 3, g, 0, grains.length / 3); } finally { sand.free(p), sand.free(g); }
  }

  place(event) {
    const box = by("view").getBoundingClientRect();
    const at = this.camera.onPlane((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height, box.width / box.height);
    return at && Math.hypot(...at) < 1.2 ? at : null;
  }
}

// The fixed run: the scene's own frames, all work, no shadows. Its hash is that of every other machine. `shown` is
// called with the share that is done.
async function fixedRun(sand, frames = k_scene.frames, shown = () => {}) {
  const scene = new SandScene(sand, k_scene, { clock: true }), stages = [0, 0, 0, 0, 0];
  let ms = 0, paused = performance.now();
  for (let frame = 0; frame < frames; ++frame) {
    if (performance.now() - paused > k_pause_ms) {
      shown(frame / frames);
      await new Promise((go) => setTimeout(go));
      paused = performance.now();
    }
    const report = scene.frame(k_step, 1e6);
    ms += report.elapsed_ns / 1e6;
    report.stages.forEach((stage, i) => { stages[i] += stage.elapsed_ns / 1e6; });
  }
  const result = { hash: scene.hash(), ms: ms / frames, stages: stages.map((sum) => sum / frames), grains: scene.report.grains,
    particles: scene.report.particles, isa: sand.sandglass_isa_name(sand.sandglass_scene_isa(scene.handle)) };
  scene.destroy();
  return result;
}

function asText({ hash, ms, stages, grains, particles, isa }) {
  return [`Sandglass, ${k_scene.frames} frames of the page's scene, ${particles} particles, ${grains} grains at the end`, `browser      ${navigator.userAgent}`,
    `cores        ${navigator.hardwareConcurrency}`, `kernels      ${isa}`, `a frame      ${ms.toFixed(2)} ms`,
    ...k_stages.map(([, name], i) => `  ${name.padEnd(10)} ${stages[i].toFixed(2)} ms`), `hash         ${hash}`].join("\n");
}

function listen(page) {
  const view = by("view"), fingers = new Map();
  let apart = 0;
  const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY); };
  view.addEventListener("pointerdown", (event) => {
    view.setPointerCapture(event.pointerId), fingers.set(event.pointerId, event);
    page.at = fingers.size === 1 && page.tool !== "turn" && event.button === 0 ? page.place(event) : null;
    if (fingers.size === 2) apart = spread();
  });
  view.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    fingers.set(event.pointerId, event);
    if (fingers.size === 2) page.camera.zoom(apart / spread()), apart = spread();
    if (fingers.size === 2 || page.tool === "turn" || event.buttons === 2)
      page.camera.turn((event.clientX - before.clientX) / 200 / fingers.size, (event.clientY - before.clientY) / 200 / fingers.size);
    else page.at = page.place(event);
  });
  for (const kind of ["pointerup", "pointercancel"]) view.addEventListener(kind, (event) => { fingers.delete(event.pointerId), page.at = null; });
  view.addEventListener("contextmenu", (event) => event.preventDefault());
  view.addEventListener("wheel", (event) => { event.preventDefault(), page.camera.zoom(Math.exp(event.deltaY / 800)); }, { passive: false });
  const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  view.addEventListener("keydown", (event) => {
    const step = move[event.key];
    if (step) page.mark = [page.mark[0] + 0.02 * step[0], 0, page.mark[2] + 0.02 * step[1]], say(`The mark is ${Math.round(100 * page.mark[0])} cm right and ${Math.round(100 * page.mark[2])} cm in front of the middle.`);
    if (event.key === " " || event.key === "p") page.tool = event.key === " " ? "pour" : "push", document.querySelector(`[value=${page.tool}]`).checked = true;
    if (event.key === " " || event.key === "p" || (step && page.at)) page.at = page.mark;
    if (event.key === "a" || event.key === "d") page.camera.turn(event.key === "a" ? 0.1 : -0.1, 0);
    if (event.key === "+" || event.key === "-") page.camera.zoom(event.key === "+" ? 0.9 : 1.1);
    if (event.key === "r") page.again();
    if (step || event.key === " ") event.preventDefault();
  });
  view.addEventListener("keyup", (event) => { if (event.key === " " || event.key === "p") page.at = null; });
  for (const input of document.querySelectorAll("[name=tool]")) input.addEventListener("change", () => { page.tool = input.value; });
  for (const id of ["azimuth", "polar"]) by(id).addEventListener("input", () => page.setLight());
  by("budget").addEventListener("input", () => { by("budget_label").textContent = `Budget ${by("budget").value} ms`; });
  by("details").open = innerWidth > 600;
  by("again").addEventListener("click", () => page.again());
  by("close").addEventListener("click", () => by("result").close());
  by("copy").addEventListener("click", () => navigator.clipboard.writeText(by("text").textContent).then(() => say("Copied."), () => say("This browser does not copy. Select the text and copy it.")));
  by("measure").addEventListener("click", () => {
    if (page.measuring) return;
    page.measuring = true;
    fixedRun(page.sand, k_scene.frames, (share) => say(`Measuring: ${Math.round(100 * share)} %`)).then((result) => {
      by("text").textContent = asText(result), by("result").showModal();
    }).catch((error) => error.message).then((sentence) => { say(sentence ?? ""), page.measuring = false; });
  });
  const take = async (file) => {
    try {
      if (/\.json$/i.test(file.name)) {
        page.measuring = true;
        const recording = await file.text().then(JSON.parse).catch(() => null);
        const hash = await page.play(recording, (share) => say(`Playing: ${Math.round(100 * share)} %`));
        return say(`The recording ends here as it did where it was made, to the bit: ${hash}.`);
      }
      if (!/\.obj$/i.test(file.name)) throw new Error(`"${file.name}" is neither an OBJ file nor a recording. Export the mesh as OBJ.`);
      say(`${page.addMesh(await file.text())} particles of "${file.name}".`);
    } catch (error) { say(error.message); } finally { page.measuring = false; }
  };
  by("save").addEventListener("click", () => {
    const link = document.createElement("a"), url = URL.createObjectURL(new Blob([JSON.stringify(page.recording())], { type: "application/json" }));
    Object.assign(link, { href: url, download: "sandglass_recording.json" }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
    say(`Saved ${page.recorded.length} frames. Drop the file on this page, on any device, to play it.`);
  });
  by("file").addEventListener("change", () => by("file").files[0] && take(by("file").files[0]));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => { event.preventDefault(); if (event.dataTransfer.files[0]) take(event.dataTransfer.files[0]); });
}

async function begin() {
  const page = new Page(await load(unpacked(k_module, Uint8Array)));
  listen(page);
  window.sandglassPage = { page, fixedRun: (frames) => fixedRun(page.sand, frames) };  // for the page's test
  let before = performance.now(), told = 0;
  const frame = (now) => {
    if (!page.measuring) page.advance(Math.max(0, now - before) / 1e3), page.draw();
    before = now;
    if (now - told > 250) page.tell(), told = now;
    if (page.scene.report.grains > 0) document.documentElement.dataset.sand ??= Math.round(performance.now());
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

begin().catch((error) => say(error.message));
