// Layout, checks and material of the granular stages.
#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

// Arrays may be read one vector beyond their last item.
constexpr uint64_t k_slack = 2 * k_lane_group;

uint32_t round_up(uint32_t count, uint32_t to) { return (count + to - 1) / to * to; }

uint32_t power_of_two(uint64_t at_least) {
  uint32_t p = 512;  // 8 cells an axis, the fewest that a sweep looks at
  while (p < at_least && p < (1u << 30)) p *= 2;
  return p;
}

void layout_sort(CellSort* sort, Layout* layout, const char* starts_name, const char* keys_name, uint64_t records,
                 uint64_t cells) {
  sort->cells_max = power_of_two(cells);
  sort->starts = layout_region<uint32_t>(layout, starts_name, static_cast<uint64_t>(sort->cells_max) + k_slack);
  sort->keys = layout_region<uint32_t>(layout, keys_name, records + k_slack);
}

constexpr float k_at_rest[3] = {0.0f, 0.0f, 0.0f};

}  // namespace

// Inert records after the last particle, so that whole vectors can be processed; their rows point at inert neighbours.
void granular_seal_particles(Granular* g) {
  for (uint32_t i = g->particle_count; i < g->particle_rows && i < g->particle_count + k_slack; ++i) {
    for (Particle* records : g->records) {
      if (records != nullptr) records[i] = inert_particle();
    }
    g->counts[i] = 0;
    for (uint32_t s = 0; s < k_list_slots; ++s) g->lists[static_cast<uint64_t>(i) * k_list_slots + s] = g->inert;
  }
}

namespace {

bool all_within(const float* values, uint32_t count, float limit) {
  for (uint64_t i = 0; i < static_cast<uint64_t>(count) * 3; ++i) {
    if (!(__builtin_fabsf(values[i]) <= limit)) return false;  // NaN fails too
  }
  return true;
}

sandglass_status fail(sandglass_status status, const char* sentence, const char** reason) {
  if (reason != nullptr) *reason = sentence;
  return status;
}

constexpr float k_speed_limit = 1e4f;  // m/s that material may be added with

}  // namespace

const char* granular_refuse(const sandglass_granular_desc& d) {
  const auto outside = [](float value, float low, float high) { return !(value >= low && value <= high); };
  if (d.particle_capacity == 0) {
    return d.grain_capacity != 0 || d.boundary_capacity != 0
               ? "granular.grain_capacity or boundary_capacity is set but particle_capacity is 0: give particles room, "
                 "or set both to 0."
               : nullptr;
  }
  if (d.particle_capacity > 4000000) return "granular.particle_capacity is above 4 million: split the scene.";
  if (d.grain_capacity > 64000000) return "granular.grain_capacity is above 64 million: split the scene.";
  if (d.boundary_capacity > 4000000)
    return "granular.boundary_capacity is above 4 million: sample the surface more coarsely.";
  if (d.collider_capacity > 256) return "granular.collider_capacity is above 256: pass the nearest colliders only.";
  if (d.emitter_capacity > 64) return "granular.emitter_capacity is above 64: join nozzles.";
  if (d.sink_capacity > 64) return "granular.sink_capacity is above 64: join sinks.";
  if (d.body_capacity > 255) return "granular.body_capacity is above 255: join bodies that move together.";
  if (d.body_particle_capacity > d.particle_capacity)
    return "granular.body_particle_capacity is above particle_capacity, which counts the bodies' particles too: raise "
           "that.";
  if (outside(d.particle_radius, 1e-4f, 10.0f))
    return "granular.particle_radius must be 0.0001 to 10 metres: set the radius r of a particle.";
  if (outside(d.grain_radius, 0.0f, d.particle_radius))
    return "granular.grain_radius must be 0 (automatic) to particle_radius.";
  if (outside(d.static_friction, 0.0f, 10.0f)) return "granular.static_friction must be 0 to 10.";
  if (outside(d.kinetic_friction, 0.0f, 10.0f)) return "granular.kinetic_friction must be 0 to 10.";
  if (outside(d.height_weighting, 0.0f, 1.5f)) return "granular.height_weighting must be 0 (off) to 1.5.";
  if (d.reference.scheme != SANDGLASS_SCHEME_SMALL_STEP && d.reference.scheme != SANDGLASS_SCHEME_AVERAGED)
    return "granular.reference.scheme must be a SANDGLASS_SCHEME value.";
  if (d.reference.solver_iterations < 1 || d.reference.solver_iterations > 64)
    return "granular.reference.solver_iterations must be 1 to 64.";
  if (d.reference.stabilisation_iterations > 8) return "granular.reference.stabilisation_iterations must be 0 to 8.";
  const float most = d.reference.scheme == SANDGLASS_SCHEME_SMALL_STEP ? 0.45f : 2.0f;
  if (!(d.reference.relaxation > 0.0f && d.reference.relaxation <= most)) {
    return "granular.reference.relaxation must be above 0 and at most 0.45 (SMALL_STEP) or 2 (AVERAGED): above "
           "that, piles blow up.";
  }
  if (!(d.courant > 0.0f && d.courant <= 1.0f)) return "granular.courant must be above 0 and at most 1.";
  if (outside(d.substep_max, 0.0f, 0.1f)) return "granular.substep_max must be 0 (automatic) to 0.1 seconds.";
  if (outside(d.substep_min, 0.0f, 0.1f)) return "granular.substep_min must be 0 (automatic) to 0.1 seconds.";
  if (d.substep_min > 0.0f && d.substep_max > 0.0f && d.substep_min > d.substep_max)
    return "granular.substep_min must not exceed substep_max.";
  if (outside(d.list_skin, 0.1f, 1.0f)) return "granular.list_skin must be 0.1 to 1 particle radius.";
  if (d.reference.blend != SANDGLASS_BLEND_CONTINUOUS && d.reference.blend != SANDGLASS_BLEND_SOURCE)
    return "granular.reference.blend must be a SANDGLASS_BLEND value.";
  if (outside(d.sleep_after, 0.0f, 5.0f)) return "granular.sleep_after must be 0 (never) to 5 seconds.";
  if (outside(d.refine_step, 1e-4f, 0.1f)) return "granular.refine_step must be 0.0001 to 0.1 seconds.";
  return nullptr;
}

void granular_layout(Granular* g, const sandglass_granular_desc& d, Layout* layout) {
  g->desc = d;
  if (d.particle_capacity == 0) return;
  g->particle_rows = round_up(d.particle_capacity, k_lane_group) + k_slack;
  g->inert = g->particle_rows + d.boundary_capacity;
  const uint64_t records = static_cast<uint64_t>(g->inert) + k_slack;
  const bool several_passes = d.reference.solver_iterations + d.reference.stabilisation_iterations > 1;
  g->records[0] = layout_region<Particle>(layout, "granular.particles", records);
  g->records[1] = layout_region<Particle>(layout, "granular.particles_next", records);
  g->records[2] = layout_region<Particle>(layout, "granular.particles_between", several_passes ? records : 0);
  const char* const axes[3] = {"granular.sorted_x", "granular.sorted_y", "granular.sorted_z"};
  const char* const boundary_axes[3] = {"granular.boundary_x", "granular.boundary_y", "granular.boundary_z"};
  const char* const snapshot_axes[3] = {"granular.snapshot_x", "granular.snapshot_y", "granular.snapshot_z"};
  const bool grains = d.grain_capacity != 0, boundary = d.boundary_capacity != 0;
  const uint64_t rows = g->particle_rows;
  const uint64_t grain_rows = static_cast<uint64_t>(d.grain_capacity) + k_slack;
  for (int k = 0; k < 3; ++k) {
    g->positions[k] = layout_region<float>(layout, axes[k], rows + k_slack);
    g->boundary_positions[k] =
        layout_region<float>(layout, boundary_axes[k], boundary ? d.boundary_capacity + k_slack : 0);
    g->snapshot_positions[k] = layout_region<float>(layout, snapshot_axes[k], grains ? rows + k_slack : 0);
  }
  g->lists = layout_region<uint32_t>(layout, "granular.lists", rows * k_list_slots);
  g->counts = layout_region<uint8_t>(layout, "granular.list_counts", rows);
  const uint64_t groups = rows / k_lane_group + 1;
  g->active_groups = layout_region<uint32_t>(layout, "granular.active_groups", groups);
  g->group_states = layout_region<GroupState>(layout, "granular.group_states", groups);
  g->touched = layout_region<uint8_t>(layout, "granular.touched", groups);
  g->rest = layout_region<Rest>(layout, "granular.rest", d.particle_capacity);
  g->free_particles = layout_region<uint32_t>(layout, "granular.free_particles", d.particle_capacity);
  g->free_grains = layout_region<uint32_t>(layout, "granular.free_grains", d.grain_capacity);
  g->emitters = layout_region<sandglass_emitter>(layout, "granular.emitters", d.emitter_capacity);
  g->emitter_states = layout_region<EmitterState>(layout, "granular.emitter_states", d.emitter_capacity);
  g->sinks = layout_region<ColliderFrame>(layout, "granular.sinks", d.sink_capacity);
  g->bodies = layout_region<RigidBody>(layout, "granular.bodies", d.body_capacity);
  g->body_rest = layout_region<float>(layout, "granular.body_rest", 3ull * d.body_particle_capacity);
  g->body_rows = layout_region<uint32_t>(layout, "granular.body_rows", d.body_particle_capacity);
  g->body_numbers = layout_region<uint32_t>(layout, "granular.body_numbers", d.body_particle_capacity);
  layout_sort(&g->particle_sort, layout, "granular.cells", "granular.cell_keys", rows, 4ull * rows);
  if (boundary) {
    layout_sort(&g->boundary_sort, layout, "granular.boundary_cells", "granular.boundary_keys", d.boundary_capacity,
                4ull * d.boundary_capacity);
  }
  if (grains) {
    g->snapshot = layout_region<Particle>(layout, "granular.snapshot", rows);
    layout_sort(&g->snapshot_sort, layout, "granular.snapshot_cells", "granular.snapshot_keys", rows, 2ull * rows);
    g->grains[0] = layout_region<Grain>(layout, "granular.grains", grain_rows);
    g->grains[1] = layout_region<Grain>(layout, "granular.grains_sorted", grain_rows);
    layout_sort(&g->grain_sort, layout, "granular.grain_cells", "granular.grain_keys", grain_rows, grain_rows);
    g->grain_sort.serpentine = true;
    const uint64_t grain_groups = round_up(d.grain_capacity, k_lane_group) / k_lane_group;
    g->grain_groups = layout_region<uint32_t>(layout, "granular.grain_groups", grain_groups);
    g->grain_still = layout_region<uint8_t>(layout, "granular.grain_still", grain_groups);
    g->grain_tiles = layout_region<Sleeper>(layout, "granular.grain_tiles", grain_groups + k_slack);
    g->awake_cells[0] = layout_region<uint8_t>(layout, "granular.awake_cells", g->snapshot_sort.cells_max);
    g->awake_cells[1] = layout_region<uint8_t>(layout, "granular.awake_cells_spread", g->snapshot_sort.cells_max);
  }
  g->colliders = layout_region<sandglass_collider>(layout, "granular.colliders", d.collider_capacity);
  g->substep_colliders = layout_region<ColliderFrame>(layout, "granular.substep_colliders", d.collider_capacity);
  g->sweep_colliders = layout_region<ColliderFrame>(layout, "granular.sweep_colliders", d.collider_capacity);
  g->colliders_before = layout_region<sandglass_collider>(layout, "granular.colliders_before", d.collider_capacity);
  g->sweep_colliders_before =
      layout_region<sandglass_collider>(layout, "granular.sweep_colliders_before", d.collider_capacity);
  g->moved.frames = layout_region<ColliderFrame>(layout, "granular.moved_colliders", 2ull * d.collider_capacity);
  g->moved.margins = layout_region<float>(layout, "granular.moved_margins", 2ull * d.collider_capacity);
  g->sweep_moved.frames = layout_region<ColliderFrame>(layout, "granular.sweep_moved", 2ull * d.collider_capacity);
  g->sweep_moved.margins = layout_region<float>(layout, "granular.sweep_moved_margins", 2ull * d.collider_capacity);
}

void granular_reset(Granular* g) {
  if (g->desc.particle_capacity == 0) return;
  g->particle_count = g->boundary_count = g->grain_count = g->collider_count = g->solid_count = 0;
  g->phase = ParticlePhase::idle;
  g->grain_phase = GrainPhase::idle;
  g->cursor = g->pass = g->grain_cursor = g->output_cursor = g->interval_left = g->dither = 0;
  g->sweeps_since_sort = 1e9f;
  g->lists_valid = g->bounds_known = false;
  g->list_slack = g->last_spread = g->speed_max = g->sweep_step = g->frame_step = 0.0f;
  g->substep = g->last_substep = g->substep_max;
  g->owed = g->interval_owed = g->slipped = g->simulated = g->unswept = g->sweep_time = 0.0;
  g->builds_per_substep = 0.25f;
  g->active_count = g->awake_count = g->collider_before_count = g->moved.count = 0;
  g->grain_group_count = g->sweep_collider_before_count = g->mark_pass = g->still_groups = 0;
  g->grains_asleep = g->groups_changed = false;
  g->next_rest = 0.0;
  g->waking_count = g->body_count = g->body_particle_count = 0;
  g->free_particle_count = g->free_grain_count = g->emitter_count = g->sink_count = 0;
  g->emitted_particles = g->emitted_grains = g->removed_particles = g->removed_grains = g->denied_particles = 0;
  for (uint32_t e = 0; e < g->desc.emitter_capacity; ++e) g->emitter_states[e] = {};
  g->drain_due = g->adopts_colliders = false;
  g->densest_body = 0.0f;
  g->touch_due = g->wake_due = g->rest_due = false;
  for (int k = 0; k < 3; ++k) g->low[k] = g->high[k] = 0.0f;
  for (Particle* records : g->records) {
    if (records != nullptr) records[g->inert] = inert_particle();
  }
  granular_seal_particles(g);
}

sandglass_status granular_add(Granular* g, const float* particles, const float* particle_velocities,
                              uint32_t particle_count, const float* grains, const float* grain_velocities,
                              uint32_t grain_count, const char** reason) {
  if ((particle_count != 0 && particles == nullptr) || (grain_count != 0 && grains == nullptr)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "particle_positions or grain_positions is NULL but its count is above 0: pass 3 floats for each item.",
                reason);
  }
  if (particle_count > g->desc.particle_capacity - g->particle_count) {
    return fail(SANDGLASS_ERROR_CAPACITY, "more particles than granular.particle_capacity has room for: raise it.",
                reason);
  }
  if (grain_count > g->desc.grain_capacity - g->grain_count) {
    return fail(SANDGLASS_ERROR_CAPACITY, "more grains than granular.grain_capacity has room for: raise it.", reason);
  }
  if (!all_within(particles, particle_count, SANDGLASS_COORDINATE_LIMIT) ||
      !all_within(grains, grain_count, SANDGLASS_COORDINATE_LIMIT)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "a position is not finite or more than 1000 m from the scene origin: move the "
                "origin nearer.",
                reason);
  }
  if ((particle_velocities != nullptr && !all_within(particle_velocities, particle_count, k_speed_limit)) ||
      (grain_velocities != nullptr && !all_within(grain_velocities, grain_count, k_speed_limit))) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "a velocity is not finite or above 10000 m/s: check where it comes from.", reason);
  }
  if (particle_count != 0) granular_abandon_substep(g);
  for (uint32_t i = 0; i < particle_count; ++i) {
    const uint32_t index = g->particle_count + i;
    const float* position = particles + 3ull * i;
    const float* velocity = particle_velocities == nullptr ? k_at_rest : particle_velocities + 3ull * i;
    // Live and free numbers together are 0, 1, 2, ...: without free ones the next is the count.
    const uint32_t number = g->free_particle_count != 0 ? g->free_particles[--g->free_particle_count] : index;
    g->records[0][index] = moving_particle(position, velocity, number);
    Rest& rest = g->rest[number];
    for (int k = 0; k < 3; ++k) rest.anchor[k] = position[k];
    rest.quiet = 0;
    ++g->awake_count;
    float speed2 = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const bool first = !g->bounds_known;
      if (first || position[k] < g->low[k]) g->low[k] = position[k];
      if (first || position[k] > g->high[k]) g->high[k] = position[k];
      speed2 += velocity[k] * velocity[k];
    }
    g->bounds_known = true;
    const float speed = __builtin_sqrtf(speed2);
    if (speed > g->speed_max) g->speed_max = speed;
  }
  for (uint32_t i = 0; i < grain_count; ++i) {
    const uint32_t index = g->grain_count + i;
    const uint32_t number = g->free_grain_count != 0 ? g->free_grains[--g->free_grain_count] : index;
    const float* velocity = grain_velocities == nullptr ? k_at_rest : grain_velocities + 3ull * i;
    g->grains[0][index] = moving_grain(grains + 3ull * i, velocity, number);
  }
  if (particle_count != 0) {
    g->particle_count += particle_count;
    g->lists_valid = false;
    if (g->grain_phase == GrainPhase::snapshot) g->grain_phase = GrainPhase::idle;
    granular_seal_particles(g);
  }
  if (grain_count != 0) {
    g->grain_count += grain_count;
    if (g->grain_phase != GrainPhase::refine && g->grain_phase != GrainPhase::drain) g->grain_phase = GrainPhase::idle;
    for (uint32_t group = (g->grain_count - grain_count) / k_lane_group; group * k_lane_group < g->grain_count; ++group)
      g->grain_still[group] = 0;
    g->sweeps_since_sort = 1e9f;
    g->grains_asleep = false;
  }
  if (reason != nullptr) *reason = nullptr;
  return SANDGLASS_OK;
}

void granular_sort_boundary(Granular* g, uint32_t count) {
  g->boundary_count = count;
  const uint32_t rows = g->particle_rows;
  const uint64_t bytes = count * sizeof(Particle);
  if (count != 0) {
    Particle* sorted = g->records[0] + rows;
    Particle* unsorted = g->records[1] + rows;
    __builtin_memcpy(unsorted, sorted, bytes);
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) low[k] = high[k] = unsorted[0].position[k];
    for (uint32_t i = 0; i < count; ++i) {
      const float* p = unsorted[i].position;
      for (int k = 0; k < 3; ++k) low[k] = p[k] < low[k] ? p[k] : low[k], high[k] = p[k] > high[k] ? p[k] : high[k];
    }
    cell_sort_begin(&g->boundary_sort, (2.0f + g->desc.list_skin) * g->desc.particle_radius, low, high, 2);
    const SortTarget target = {
        as_records(sorted), {g->boundary_positions[0], g->boundary_positions[1], g->boundary_positions[2]}, false};
    while (g->boundary_sort.phase != k_sort_done)
      cell_sort_run(&g->boundary_sort, *g->kernels, as_records(unsorted), count, g->unit, target);
    for (int b = 1; b < 3; ++b) {
      if (g->records[b] != nullptr) __builtin_memcpy(g->records[b] + rows, sorted, bytes);
    }
  }
  for (Particle* records : g->records) {
    if (records != nullptr) records[g->inert] = inert_particle();
  }
}

sandglass_status granular_set_boundary(Granular* g, const float* positions, uint32_t count, const char** reason) {
  if (count > g->desc.boundary_capacity) {
    return fail(SANDGLASS_ERROR_CAPACITY,
                "sandglass_granular_set_boundary: more particles than granular.boundary_capacity: raise it.", reason);
  }
  if (count != 0 && positions == nullptr) {
    return fail(
        SANDGLASS_ERROR_INVALID_ARGUMENT,
        "sandglass_granular_set_boundary: positions is NULL but count is above 0: pass 3 floats for each sample.",
        reason);
  }
  if (!all_within(positions, count, SANDGLASS_COORDINATE_LIMIT)) {
    return fail(SANDGLASS_ERROR_INVALID_ARGUMENT,
                "sandglass_granular_set_boundary: a position is not finite or more than 1000 m from the scene origin: "
                "move the origin nearer.",
                reason);
  }
  granular_wake_all(g);
  for (uint32_t i = 0; i < count; ++i) g->records[0][g->particle_rows + i] = fixed_particle(positions + 3ull * i, i);
  granular_sort_boundary(g, count);
  if (reason != nullptr) *reason = nullptr;
  return SANDGLASS_OK;
}

}  // namespace sandglass
