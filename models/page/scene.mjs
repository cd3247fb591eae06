// Builds a scene in the module from what web_scene writes, and runs its frames as the program does.

export const unpacked = (text, Type) =>
  new Type((Uint8Array.fromBase64?.(text) ?? Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))).buffer);

// The field of a file's mesh, made by the library as the file says: its bytes, for another instance's memory too. Throws the
// library's sentence.
export function fieldBytes(sand, plan) {
  const vertices = unpacked(plan.vertices, Float32Array);
  const indices = unpacked(plan.indices, Uint32Array);
  const size = sand.allocate(8);
  const mesh = sand.make("sandglass_mesh", {
    vertices: sand.put(vertices),
    vertex_count: vertices.length / 3,
    indices: sand.put(indices),
    triangle_count: indices.length / 3,
  });
  const inside = sand.create("sandglass_mesh_inside", mesh, plan.rule);
  const desc = sand.make("sandglass_field_desc", {
    solid: plan.solid,
    bounds_min: plan.low,
    bounds_max: plan.high,
    spacing: plan.spacing,
    band: plan.band,
    mesh,
    inside: sand.pointer("sandglass_mesh_inside_test"),
    inside_user: inside,
  });
  const field = sand.create("sandglass_field", desc);
  sand.sandglass_field_bytes(desc, size);
  const bytes = sand.bytes(field, Number(sand.view().getBigUint64(size, true))).slice();
  for (const used of [mesh.vertices, mesh.indices, mesh, inside, desc, size, field]) sand.free(used);
  return bytes;
}

// Adds typed arrays of particles and grains: { positions, velocities } of each; without velocities they are at rest.
export function addPoints(sand, scene, ...particlesAndGrains) {
  const made = particlesAndGrains.map(({ positions, velocities }) =>
    sand.make("sandglass_points", {
      positions: sand.put(positions),
      velocities: velocities && sand.put(velocities),
      count: positions.length / 3,
    }),
  );
  try {
    sand.sandglass_scene_add(scene, ...made);
  } finally {
    for (const points of made) for (const used of [points.positions, points.velocities, points]) sand.free(used);
  }
}

// With the module's pool, if it has one. `changes` are fields of sandglass_granular_desc that differ from the file's; `isa` is a sandglass_isa.
export class SandScene {
  constructor(sand, file, { isa = 0, clock = false, changes = {}, colliders = 0 } = {}) {
    this.sand = sand;
    this.file = file;
    this.frames = 0;
    const desc = (this.desc = sand.make("sandglass_scene_desc"));
    sand.sandglass_scene_desc_default(desc);
    desc.isa = isa;
    desc.gravity = file.gravity;
    desc.granular.set(file.granular).set(changes);
    desc.parallel.set(sand.parallel);
    if (clock) desc.clock = sand.sandglass_clock_system();
    this.handle = sand.create("sandglass_scene", desc);
    this.fill();

    // The file's colliders come first, then as many more as were asked for.
    this.colliders = sand.array("sandglass_collider", file.colliders.length + colliders);
    this.fields = [];
    file.colliders.forEach(({ shape, position, rotation, size, field }, i) => {
      this.fields.push(
        typeof field === "number" ? field : field ? sand.put((field.made ??= fieldBytes(sand, field))) : 0,
      );
      this.colliders[i].set({ shape, position, rotation, size, field: this.fields[i] });
    });
    this.emitters = sand.array("sandglass_emitter", Math.max(1, desc.granular.emitter_capacity));
    this.grains = sand.allocate(16 * Math.max(1, desc.granular.grain_capacity));
    this.input = sand.make("sandglass_frame_input");
    sand.sandglass_frame_input_default(this.input);
    this.input.colliders = this.colliders.address;
    this.input.collider_count = file.colliders.length;
    this.input.emitters = this.emitters.address;
    this.input.grains = this.grains;
    this.input.grain_capacity = desc.granular.grain_capacity;
    this.report = sand.make("sandglass_frame_report");
  }

  fill() {
    const { sand, file } = this;
    const array = (name) =>
      file[name] instanceof Float32Array ? file[name] : unpacked(file[name] ?? "", Float32Array);
    const particles = array("particles");
    const velocities = file.particle_velocities ? array("particle_velocities") : undefined;
    addPoints(
      sand,
      this.handle,
      { positions: particles, velocities },
      { positions: array("grains"), velocities: array("grain_velocities") },
    );
  }

  // The file's emitters that are on when the coming frame begins. Gives how many.
  pourAsTheFileSays() {
    const time = this.frames * this.file.frame_step;
    const on = this.file.emitters.filter((emitter) => time >= emitter.start && time < emitter.end);
    on.forEach(({ position, rotation, radius, speed, grains_per_particle }, i) =>
      this.emitters[i].set({ position, rotation, radius, speed, grains_per_particle }),
    );
    return on.length;
  }

  // One frame; without a budget it does all its work.
  frame(step = this.file.frame_step, budget_ms = Infinity, emitters = this.pourAsTheFileSays()) {
    const { sand, input } = this;
    input.time_step = step;
    input.emitter_count = emitters;
    input.budget_ns = budget_ms === Infinity ? 2n ** 64n - 1n : BigInt(Math.round(budget_ms * 1e6));
    sand.sandglass_scene_frame(this.handle, input, this.report);
    ++this.frames;
    return this.report;
  }

  // Gives all memory back.
  destroy() {
    const { sand, handle, desc, colliders, emitters, grains, input, report, fields } = this;
    sand.destroy(handle);
    for (const used of [desc, colliders, emitters, grains, input, report, ...fields]) sand.free(used);
  }

  hash() {
    return "0x" + this.sand.sandglass_scene_hash(this.handle).toString(16).padStart(16, "0");
  }
}
