// The whole, put together from its parts: checks, layout, reset, settling, and the beginning of a frame.
#include "runtime/sand/granular.h"

#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"

namespace sandglass {

namespace {

// grain_radius 0: about the size at which 16 grains fill a particle's share of space.
constexpr float k_grain_radii = 0.35f;

// Sub-step of the calibrated scheme in units of sqrt(r/g): 20 ms / 36 for r = 1 cm.
constexpr float k_substep_units = 0.01742f;

// Seconds; what an app may ask for. A frame of 0.2 s then has 200,000 sub-steps.
constexpr float k_shortest_substep = 1e-6f;

// The share of gravity's length by which it may change before what sleeps wakes: a turn by 1.1 degrees.
constexpr float k_gravity_wakes = 0.02f;

float length_of(const float v[3]) { return __builtin_sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

const char* granular_refuse(const sandglass_granular_desc& d) {
  const auto outside = [](float value, float low, float high) { return !within(value, low, high); };
  if (d.particle_capacity == 0) {
    return d.grain_capacity != 0 || d.boundary_capacity != 0
               ? "granular.grain_capacity or boundary_capacity is set but particle_capacity is 0: give particles room, "
                 "or set both to 0."
               : nullptr;
  }
  if (d.particle_capacity > SANDGLASS_PARTICLE_LIMIT)
    return "granular.particle_capacity is above 4 million: split the scene.";
  if (d.grain_capacity > SANDGLASS_GRAIN_LIMIT) return "granular.grain_capacity is above 64 million: split the scene.";
  if (d.boundary_capacity > SANDGLASS_PARTICLE_LIMIT)
    return "granular.boundary_capacity is above 4 million: sample the surface more coarsely.";
  if (d.collider_capacity > SANDGLASS_COLLIDER_LIMIT)
    return "granular.collider_capacity is above 256: pass the nearest colliders only.";
  if (d.emitter_capacity > SANDGLASS_FLOW_LIMIT) return "granular.emitter_capacity is above 64: join nozzles.";
  if (d.sink_capacity > SANDGLASS_FLOW_LIMIT) return "granular.sink_capacity is above 64: join sinks.";
  if (d.body_capacity > 255) return "granular.body_capacity is above 255: join bodies that move together.";
  if (d.body_particle_capacity > d.particle_capacity)
    return "granular.body_particle_capacity is above particle_capacity, which counts the bodies' particles too: raise "
           "that.";
  if (outside(d.particle_radius, 1e-4f, 10.0f))
    return "granular.particle_radius must be 0.0001 to 10 metres: set the radius r of a particle.";
  if (outside(d.grain_radius, 0.0f, d.particle_radius))
    return "granular.grain_radius must be 0 (automatic) to particle_radius.";
  if (outside(d.static_friction, 0.0f, SANDGLASS_FRICTION_LIMIT)) return "granular.static_friction must be 0 to 10.";
  if (outside(d.kinetic_friction, 0.0f, SANDGLASS_FRICTION_LIMIT)) return "granular.kinetic_friction must be 0 to 10.";
  if (outside(d.height_weighting, 0.0f, 1.5f)) return "granular.height_weighting must be 0 (off) to 1.5.";
  if (d.reference.scheme != SANDGLASS_SCHEME_SMALL_STEP && d.reference.scheme != SANDGLASS_SCHEME_AVERAGED)
    return "granular.reference.scheme must be a SANDGLASS_SCHEME value.";
  if (d.reference.solver_iterations < 1 || d.reference.solver_iterations > 64)
    return "granular.reference.solver_iterations must be 1 to 64.";
  if (d.reference.stabilisation_iterations > 8) return "granular.reference.stabilisation_iterations must be 0 to 8.";
  const float limit = d.reference.scheme == SANDGLASS_SCHEME_SMALL_STEP ? 1.0f : 2.0f;
  if (!(d.reference.relaxation > 0.0f && d.reference.relaxation <= limit)) {
    return "granular.reference.relaxation must be above 0 and at most 1 (SMALL_STEP) or 2 (AVERAGED): above "
           "that, piles blow up.";
  }
  if (!(d.courant > 0.0f && d.courant <= 1.0f)) return "granular.courant must be above 0 and at most 1.";
  if (d.substep_max != 0.0f && outside(d.substep_max, k_shortest_substep, SANDGLASS_SUBSTEP_LIMIT))
    return "granular.substep_max must be 0 (automatic), or 0.000001 to 0.1 seconds.";
  if (d.substep_min != 0.0f && outside(d.substep_min, k_shortest_substep, SANDGLASS_SUBSTEP_LIMIT))
    return "granular.substep_min must be 0 (automatic), or 0.000001 to 0.1 seconds.";
  if (d.substep_min > 0.0f && d.substep_max > 0.0f && d.substep_min > d.substep_max)
    return "granular.substep_min must not exceed substep_max.";
  if (outside(d.list_margin, 0.1f, 1.0f)) return "granular.list_margin must be 0.1 to 1 particle radius.";
  if (d.reference.blend < SANDGLASS_BLEND_CONTINUOUS || d.reference.blend > SANDGLASS_BLEND_MEANS)
    return "granular.reference.blend must be a SANDGLASS_BLEND value.";
  if (outside(d.sleep_after, 0.0f, 5.0f)) return "granular.sleep_after must be 0 (never) to 5 seconds.";
  if (outside(d.refine_step, 1e-4f, 0.1f)) return "granular.refine_step must be 0.0001 to 0.1 seconds.";
  if (outside(d.collider_band, 0.0f, 0.1f)) return "granular.collider_band must be 0 (off) to 0.1 metres.";
  if (outside(d.lowest, 0.0f, 2.0f * SANDGLASS_COORDINATE_LIMIT))
    return "granular.lowest must be 0 (never) to 2000 metres.";
  return nullptr;
}

// A sweep sorts the grains, and then adds up the particles' motion, in the same memory.
static void sweep_space_layout(Granular* g, const sandglass_granular_desc& d, Layout* layout) {
  if (d.grain_capacity == 0) return;
  const auto lay_out = [&](uint8_t* base) {
    Layout sort, planes;
    sort.base = planes.base = base;
    grains_sort_layout(&g->grains, d, &sort);
    motion_planes_layout(&g->motion, d, &planes);
    return sort.size > planes.size ? sort.size : planes.size;
  };
  lay_out(layout_region<uint8_t>(layout, "granular.sweep_space", lay_out(nullptr)));
}

void granular_layout(Granular* g, const sandglass_granular_desc& d, Layout* layout) {
  g->desc = d;
  if (d.particle_capacity == 0) {  // nothing meets a collider, is poured, or drains
    g->desc.collider_capacity = g->desc.emitter_capacity = g->desc.sink_capacity = 0;
    g->desc.body_capacity = g->desc.body_particle_capacity = 0;
    return;
  }
  particles_layout(&g->particles, d, layout);
  neighbours_layout(&g->neighbours, g->particles.rows, layout);
  if (solves_pairs(*g)) pair_colours_layout(&g->colours, d, g->particles.rows, layout);
  sleep_layout(&g->sleep, d, g->particles.rows, layout);
  boundary_layout(&g->boundary, d, layout);
  bodies_layout(&g->bodies, d, layout);
  departed_layout(&g->departed, d, layout);
  carry_layout(&g->carry, d, layout);
  flow_layout(&g->flow, d, layout);
  grains_layout(&g->grains, d, g->particles.rows, layout);
  motion_layout(&g->motion, d, layout);
  sweep_space_layout(g, d, layout);
  grain_sleep_layout(&g->grain_sleep, d, layout);
  grain_carry_layout(&g->grain_carry, d, layout);
  output_layout(&g->output, d, layout);
  colliders_layout(&g->colliders, d, layout);
}

void granular_configure(Granular* g, const sandglass_scene_desc& desc, const Kernels* kernels) {
  g->kernels = kernels;
  g->parallel = desc.parallel;
  g->unit = desc.unit_items;
  granular_set_gravity(g, desc.gravity);
  motion_configure(&g->motion, g->desc);
  if (g->desc.grain_radius <= 0.0f) g->desc.grain_radius = k_grain_radii * g->desc.particle_radius;
}

bool gravity_fits(const float gravity[3]) { return length_of(gravity) <= SANDGLASS_GRAVITY_LIMIT; }

void granular_set_gravity(Granular* g, const float gravity[3]) {
  for (int k = 0; k < 3; ++k) g->gravity[k] = gravity[k];
  g->gravity_length = length_of(gravity);
  const sandglass_granular_desc& d = g->desc;
  const float pull = g->gravity_length > 0.1f ? g->gravity_length : 9.81f;  // weightless scenes keep the Earth's step
  const float longest =
      d.substep_max > 0.0f ? d.substep_max : k_substep_units * __builtin_sqrtf(d.particle_radius / pull);
  substep_set_limits(&g->substep, longest, d.substep_min > 0.0f ? d.substep_min : 0.25f * longest);
  granular_feel_gravity(g);
}

void granular_feel_gravity(Granular* g) {
  float change[3];
  for (int k = 0; k < 3; ++k) change[k] = g->gravity[k] - g->resting_gravity[k];
  if (!(length_of(change) > k_gravity_wakes * g->gravity_length)) return;
  granular_set_resting_gravity(g, g->gravity);
  if (g->sleep.awake_count != g->particles.count) granular_wake_all(g);
  grain_sleep_wake_all(&g->grain_sleep);
}

void granular_set_resting_gravity(Granular* g, const float gravity[3]) {
  for (int k = 0; k < 3; ++k) g->resting_gravity[k] = gravity[k];
}

void granular_take_friction(Granular* g, float static_friction, float kinetic_friction) {
  g->desc.static_friction = static_friction;
  g->desc.kinetic_friction = kinetic_friction;
}

void granular_reset(Granular* g) {
  if (g->desc.particle_capacity == 0) return;
  particles_reset(&g->particles);
  neighbours_reset(&g->neighbours, g->substep.longest);
  sleep_reset(&g->sleep);
  boundary_reset(&g->boundary);
  departed_reset(&g->departed);
  bodies_reset(&g->bodies);
  flow_reset(&g->flow, g->desc);
  grains_reset(&g->grains);
  grain_sleep_reset(&g->grain_sleep);
  grain_carry_reset(&g->grain_carry, *g);
  colliders_reset(&g->colliders, g->desc);
  time_reset(&g->time);
  substep_reset(&g->substep);
  carry_reset(&g->carry);
  contacts_reset(&g->contacts);
  sweep_reset(&g->sweep);
  motion_forget(&g->motion);
  output_restart(&g->output);
  output_changed(&g->output);
  g->counts = {};
  granular_seal(g);
}

void granular_settle(Granular* g) {
  if (g->desc.particle_capacity == 0) return;
  if (g->sweep.phase != SweepPhase::idle || g->time.grain_lag >= k_time_resolution) output_changed(&g->output);
  sweep_finish(g);
  substep_abandon(g);
  sweep_finish(g);  // where it ended a sub-step with bodies, grains follow once more
  substep_reset(&g->substep);
  contacts_forget(&g->contacts);
  neighbours_learn(&g->neighbours, g->counts.list_builds, g->counts.substeps);
  g->counts = {};
  neighbours_forget(&g->neighbours, g->substep.longest);
  pair_colours_forget(&g->colours);
  time_forget_interval(&g->time);
  sleep_forget_waking(&g->sleep);
  granular_forget_departed(g);
  motion_begin_here(g->motion, *g);
  sweep_forget(&g->sweep);
  motion_forget(&g->motion);
  grain_sleep_settle(&g->grain_sleep, *g);
  colliders_settle(&g->colliders, *g);
  granular_seal(g);
}

static void begin_carry(Granular* g) {
  const bool runs = !time_paused(*g) && g->particles.count != 0, moving = runs && colliders_move_sand(*g);
  carry_begin_frame(&g->carry, *g, runs && g->colliders.jumped, moving);
  if (moving || time_paused(*g) || g->time.rate >= 1.0) return;
  if (g->time.rate > 0.0) colliders_arrive(&g->colliders, *g, static_cast<float>(1.0 / g->time.rate));
  time_forget_rate(&g->time);
}

// What must find all particles where it found the first ends before. Out of line, as end_carry: units are deep enough.
__attribute__((noinline)) static void find_carriers(Granular* g) {
  substep_end_for_carry(g);
  sweep_end_snapshot(g);
  float faster = 1.0f;
  if (g->carry.due == Carry::Moment::jump) {
    colliders_find_jumps(&g->colliders, *g);
  } else {
    faster = time_find_rate(&g->time);
    colliders_arrive(&g->colliders, *g, faster);
  }
  carry_begin(&g->carry, *g, faster);
}

__attribute__((noinline)) static void end_carry(Granular* g) {
  const Carry& c = g->carry;
  colliders_carry_substep(&g->colliders, c.faster);
  const Bounds moved = carry_bounds(c, g->desc.particle_radius);  // in the sub-step under way they go less
  if (!is_empty(moved)) {
    const float gained = colliders_gain(g->colliders, c.faster) + g->particles.speed_max;
    const float pushed = __builtin_sqrtf(c.fastest2), fastest[3] = {gained > pushed ? gained : pushed, 0.0f, 0.0f};
    particles_include(&g->particles, moved.low, fastest);
    particles_include(&g->particles, moved.high, fastest);
    ContactExtent extent = k_extent_of_none;
    __builtin_memcpy(extent.low, moved.low, sizeof extent.low);
    __builtin_memcpy(extent.high, moved.high, sizeof extent.high);
    contacts_include(&g->contacts, extent);
  }
  if (!is_empty(c.resting)) sleep_include_resting(&g->sleep, c.resting);
  if (carry_mixes(*g)) neighbours_carried(&g->neighbours, (c.group_count > 1 ? 2.0f : 1.0f) * c.displacement_max);
  ++g->counts.carries;
  grain_carry_note(&g->grain_carry, *g);
  carry_end(&g->carry);
}

void granular_carry(Granular* g) {
  if (!g->carry.known) find_carriers(g);
  if (carry_run(&g->carry, *g)) end_carry(g);
}

bool granular_find_grain_motions(Granular* g, bool moved) {
  const GrainStance stance = grain_carry_stance(*g, moved);
  colliders_find_motions(&g->colliders, stance.met, stance.moves);
  carry_find_groups(&g->carry, *g);
  return grain_carry_take_motions(&g->grain_carry, *g, moved);
}

// At the end of a frame: the motions by which grains are drawn, then who holds them.
static void carry_grains(Granular* g) {
  const uint32_t moved = grain_carry_moved(*g);
  if (!g->grain_carry.known) {
    if (time_paused(*g)) return grain_carry_begin(&g->grain_carry, *g, g->grain_carry.drawn);  // all stands
    const bool rest = granular_find_grain_motions(g, false),
               any = (moved != 0 && granular_find_grain_motions(g, true)) || rest;
    if (any || g->grain_carry.drawn) {
      output_changed(&g->output);
      output_restart(&g->output);
    }
    grain_carry_begin(&g->grain_carry, *g, any);
    if (g->grain_carry.cursor == g->grains.count) return;
  } else {
    granular_find_grain_motions(g, g->grain_carry.cursor < moved);
  }
  const uint32_t cursor = g->grain_carry.cursor, end = cursor < moved ? moved : g->grains.count;
  grain_carry_found(&g->grain_carry, grain_carry_find(&g->grain_carry, *g, cursor, end));
}

void granular_begin_frame(Granular* g, const sandglass_frame_input* input) {
  neighbours_learn(&g->neighbours, g->counts.list_builds, g->counts.substeps);
  g->counts = {};
  output_begin_frame(&g->output, input);
  const double owed = g->time.debt;
  time_take(&g->time, *g, input->time_step);
  colliders_take(&g->colliders, *g, *input, owed, &g->counts);
  grain_carry_begin_frame(&g->grain_carry, *g);
  begin_carry(g);
  flow_take(&g->flow, *g, *input, &g->counts);
  if (time_paused(*g)) return;
  const bool touch = colliders_find_moved(&g->colliders, *g);
  if (!g->colliders.waits) substep_set_due(&g->substep, SubstepPhase::touch, touch);
  if (!granular_skip_time(g)) departed_begin_frame(&g->departed, *g);
}

void granular_end_frame(Granular* g) {
  output_end_frame(&g->output);
  time_end_frame(&g->time, *g);
}

bool granular_skip_time(Granular* g) {
  const bool asleep = g->sleep.awake_count == 0 && (g->neighbours.valid || g->particles.count == 0);
  if (!asleep || g->flow.emitter_count != 0 || !substep_idle(*g)) return false;
  time_skip(&g->time, *g);
  substep_end_interval(&g->substep);
  particles_stand(&g->particles);
  neighbours_stand(&g->neighbours);
  if (grain_sleep_skips_time(&g->grain_sleep, *g)) time_grains_followed(&g->time);
  return true;
}

bool inlet_let_in(const Inlet& inlet, const float* positions, const float* velocities, uint32_t particles,
                  uint32_t grains) {
  Granular* g = static_cast<Granular*>(inlet.scene);
  if (!granular_pour_in(g, {positions, velocities, particles}, {positions, velocities, grains})) return false;
  motion_fall(g->motion, *g, g->particles.count - particles);
  return true;
}

void granular_pour(Granular* g) { flow_emit(&g->flow, *g, {g}, &g->counts); }

void granular_wake_all(Granular* g) {
  substep_abandon(g);
  sleep_wake_all(&g->sleep, *g);
  neighbours_invalidate(&g->neighbours);
}

void granular_forget_departed(Granular* g) {
  departed_reset(&g->departed);
  sleep_find_resting(&g->sleep, *g);
  particles_recall(&g->particles);
}

void granular_seal(Granular* g) {
  particles_seal(g->particles);
  neighbours_seal(g->neighbours, g->particles);
}

void granular_take_out_particle(Granular* g, uint32_t i) {
  const Particle& removed = g->particles.records[0][i];
  flow_free_particle_number(&g->flow, number_of(removed));
  if (is_awake(removed)) sleep_removed(&g->sleep);
  particles_remove(&g->particles, i);
  if (i < g->particles.count && in_body(g->particles.records[0][i])) bodies_note_row(*g, i);
}

void granular_take_out_grain(Granular* g, uint32_t i) {
  flow_free_grain_number(&g->flow, g->grains.records[i].number);
  grains_remove(&g->grains, i);
}

uint32_t granular_drain_particles(Granular* g, uint32_t first) {
  uint32_t found[k_lane_group];
  const uint32_t count = flow_find_leaving_particles(*g, first, found);
  for (uint32_t k = 0; k < count; ++k) granular_take_out_particle(g, found[k]);
  return count;
}

uint32_t granular_drain_grains(Granular* g, uint32_t first) {
  uint32_t found[k_lane_group];
  const uint32_t count = flow_find_leaving_grains(*g, first, found);
  for (uint32_t k = 0; k < count; ++k) granular_take_out_grain(g, found[k]);
  return count;
}

// Particles of sleeping groups may have moved to others. The next list build finds out which groups sleep.
void granular_after_removal(Granular* g) {
  neighbours_invalidate(&g->neighbours);
  substep_set_due(&g->substep, SubstepPhase::wake, false);
  sleep_forget_waking(&g->sleep);
  sweep_particles_changed(&g->sweep);
  granular_seal(g);
}

// Until its own cost is known, carrying a particle counts as completing its sub-step so many times.
constexpr uint32_t k_like_complete = 8;

// At the end of each frame: what colliders carry.
Stage granular_carry_stage(Granular* granular) {
  const auto next = [](const void* state, uint32_t, WorkUnit* unit) {
    const Granular& g = *static_cast<const Granular*>(state);
    carry_unit(g, unit);
    return g.carry.closing && carry_is_due(g);
  };
  const auto run = [](void* state, uint32_t) { granular_carry(static_cast<Granular*>(state)); };
  const auto forecast = [](const void* state, uint32_t, Forecast* entries) -> uint32_t {
    const Granular& g = *static_cast<const Granular*>(state);
    if (!carry_is_expected(g)) return 0;
    entries[0] = {k_unit_carry, g.particles.count};
    if (!g.carry.usual) entries[0] = {k_unit_complete, k_like_complete * g.particles.count};
    entries[1] = {k_unit_push, giving_usual(g.carry)};
    return 2;
  };
  const auto close = [](void* state) {
    Granular* g = static_cast<Granular*>(state);
    carry_close(&g->carry, *g);
  };
  return {granular, next, run, forecast, k_granular_kinds, k_all_units, 1.0f, 0, close};
}

// Finding the motions of colliders takes as long as finding the holders of so many grains.
constexpr uint32_t k_motions_items = 512;

// The whole output runs, after that.
Stage granular_output_stage(Granular* granular) {
  const auto next = [](const void* state, uint32_t, WorkUnit* unit) {
    const Granular& g = *static_cast<const Granular*>(state);
    const uint32_t left = g.grain_carry.unknown * k_lane_group;
    *unit = {k_unit_grain_carry, k_motions_items + (left < g.unit ? left : g.unit), "output.carry"};
    return grain_carry_is_due(g) || output_next(g, unit);
  };
  const auto run = [](void* state, uint32_t) {
    Granular* g = static_cast<Granular*>(state);
    if (grain_carry_is_due(*g)) carry_grains(g);
    else output_run(&g->output, *g);
  };
  const auto forecast = [](const void* state, uint32_t, Forecast* entries) {
    const Granular& g = *static_cast<const Granular*>(state);
    entries[0] = {k_unit_grain_carry, g.grain_carry.drawn ? k_motions_items + g.grain_carry.looked : 0};
    return 1 + output_forecast(g, entries + 1);
  };
  return {granular, next, run, forecast, k_granular_kinds, k_all_units, 1.0f};
}

}  // namespace sandglass
