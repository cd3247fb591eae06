// The particles' stage: simulated time in equal sub-steps, each a sequence of units
//     [sort -> lists]  when the lists are stale      stabilise x S   solve x I
// and, with the small-step scheme, no more than one solve pass: prediction, contacts, friction, colliders and
// integration in one.
//
// Passes run over the record groups that hold an awake particle (rest.cpp).
//
// Lists are rebuilt by displacement, not by count. A list holds every pair closer than 2r + skin when it was built, so
// it is complete while no pair has approached by more than the skin. Common motion does not count: half the range of
// the particles' displacements bounds how far any particle strays from the mean, and a falling body needs no rebuild.
#include "runtime/granular/granular.h"
#include "runtime/granular/ladder.h"

namespace sandglass {

namespace {

// What height weighting may lift a particle by in a sub-step, in units of what gravity takes from it. One unit carries
// a pile; the second brakes what falls onto it. Without a limit every contact of a tower lifts what is above it: a
// hundred particles that touched when gravity began rose to twice their height.
constexpr float k_lift_gravities = 2.0f;

// Speed of separation that an overlap may cause, in units of sqrt(g d). Contacts by position turn an overlap o into a
// speed of omega o / dt, a metre a second for a tenth of a radius: close-packed bodies bounced off the floor. Piles
// need n g dt to carry n layers, and stay far below the limit up to 100 of them.
constexpr float k_separation_units = 0.9f;

// Sand under a heavy body carries its weight as so many layers more, up to a density ratio of this: sand that may be
// driven apart faster is thrown about by bodies a thousand times as dense.
constexpr float k_heaviest_counted = 10.0f;

// Pairs closer than this when the lists were built come first in them, in radii: contacts, and those of the next few
// sub-steps.
constexpr float k_near_radii = 2.1f;

// Gravity of a sub-step is varied by this share, to and fro. A fall adds nearly the same increment in every sub-step,
// and its rounding has the same sign as long as the velocity's exponent stays: 5,000 sub-steps drifted by up to 8e-5 of
// the way, varied ones by less than 1e-5 (measured for 40 to 200 sub-steps of 20 ms).
constexpr float k_dither = 1.0f / 1024.0f;
constexpr uint32_t k_dither_stride =
    2654435769u;  // 2^32 over the golden ratio: every stretch of it averages to nothing

constexpr double k_time_resolution = 1e-9;  // seconds; less is not owed

uint32_t passes_of(const Granular& g, ParticlePhase phase) {
  return phase == ParticlePhase::stabilise ? g.desc.reference.stabilisation_iterations : g.iterations;
}

// Half the diagonal of the box that holds all displacements of a sub-step; where something stands still, the longest
// displacement.
float spread_of(const Granular& g, const ContactExtent& e) {
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) {
    float half = 0.5f * (e.displacement_high[k] - e.displacement_low[k]);
    if (g.boundary_count != 0 || g.awake_count < g.particle_count) {
      const float a = __builtin_fabsf(e.displacement_low[k]), b = __builtin_fabsf(e.displacement_high[k]);
      half = a > b ? a : b;
    }
    sum += half * half;
  }
  return __builtin_sqrtf(sum);
}

// Length of the next sub-steps: (4.45) within the scheme's range, equal parts of the interval (erratum of Alg. 5).
uint32_t substeps_for(const Granular& g, double interval, uint32_t level) {
  float limit = rung_substep(k_ladder[level], g.desc.reference.solver_iterations, g.substep_max);
  if (g.speed_max > 0.0f) {
    const float courant = g.desc.courant * g.desc.particle_radius / g.speed_max;
    limit = courant < limit ? courant : limit;
    limit = limit < g.substep_min ? g.substep_min : limit;
  }
  const double count = interval / static_cast<double>(limit);
  const uint32_t whole = static_cast<uint32_t>(count);
  // A hair above a whole number is that number: 20 ms in steps of 20/64 ms are 64.
  return count - whole > 1e-4 ? whole + 1 : (whole == 0 ? 1 : whole);
}

// Equal refinement intervals of the time owed: as many as refine_step asks for, or one a frame.
double interval_for(const Granular& g, uint32_t level) {
  const double longest = k_ladder[level].refine_often && g.desc.grain_capacity != 0
                             ? static_cast<double>(g.desc.refine_step)
                             : static_cast<double>(g.frame_step);
  const double count = g.owed / (longest > k_time_resolution ? longest : g.owed);
  const double whole = static_cast<double>(static_cast<uint32_t>(count));
  const double parts = count - whole > 1e-4 ? whole + 1.0 : (whole < 1.0 ? 1.0 : whole);
  return g.owed / parts;
}

// At full quality each interval is refined before the next; below it time slows rather than leave grains behind.
bool waits_for_grains(const Granular& g, uint32_t level) {
  if (g.grain_count == 0 || g.particle_count == 0 || g.interval_left != 0) return false;
  return k_ladder[level].refine_often ? g.unswept > k_time_resolution : granular_grains_behind(g);
}

uint32_t active_items(const Granular& g) { return g.active_count * k_lane_group; }

// What the next sub-step will be.
struct Plan {
  double interval;  // of which it is a part, seconds
  uint32_t count;   // sub-steps left in the interval, this one included
  float substep;    // seconds
  bool stale;       // the lists must be rebuilt first
};

Plan plan_substep(const Granular& g, uint32_t level) {
  Plan plan = {0.0, g.interval_left, g.substep, !g.lists_valid};
  if (plan.count == 0) {
    plan.interval = interval_for(g, level);
    plan.count = substeps_for(g, plan.interval, level);
    plan.substep = static_cast<float>(plan.interval / plan.count);
  }
  // The pass looks ahead by one sub-step of about the last one's motion.
  const float extra = (k_ladder[level].list_reuse - 1.0f) * g.desc.list_skin * g.desc.particle_radius;
  if (2.0f * g.last_spread * (plan.substep / g.last_substep) > g.list_slack + extra) plan.stale = true;
  return plan;
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  if (g.particle_count == 0 && g.emitter_count == 0) return false;
  // A snapshot under way reads the state in several units and must find it unchanged.
  if (g.grain_phase == GrainPhase::snapshot) return false;
  ParticlePhase phase = g.phase;
  uint32_t cursor = g.cursor;
  if (phase == ParticlePhase::idle) {
    if (!g.touch_due && g.interval_left == 0 && (g.owed < k_time_resolution || waits_for_grains(g, level)))
      return false;
    cursor = 0;
    phase = g.touch_due                                      ? ParticlePhase::touch
            : plan_substep(g, level).stale                   ? ParticlePhase::sort
            : g.desc.reference.stabilisation_iterations != 0 ? ParticlePhase::stabilise
                                                             : ParticlePhase::solve;
  }
  const uint32_t left = (phase == ParticlePhase::lists ? g.particle_count : active_items(g)) - cursor;
  unit->items = left < g.unit ? left : g.unit;
  switch (phase) {
    case ParticlePhase::sort:
      unit->kind = k_unit_particle_sort, unit->name = "granular.sort";
      unit->items = g.phase == ParticlePhase::sort ? cell_sort_items(g.particle_sort, g.particle_count, g.unit)
                                                   : (g.particle_count < g.unit ? g.particle_count : g.unit);
      break;
    case ParticlePhase::lists:
      unit->kind = k_unit_lists, unit->name = "granular.lists";
      break;
    case ParticlePhase::wake_lists:
      unit->kind = k_unit_lists, unit->name = "granular.wake_lists";
      unit->items = granular_rest_items(g);
      break;
    case ParticlePhase::bodies:
      unit->kind = k_unit_bodies, unit->name = "granular.bodies";
      unit->items = granular_body_items(g);
      break;
    case ParticlePhase::touch:
      unit->kind = k_unit_touch, unit->name = "granular.touch";
      unit->items = granular_rest_items(g);
      break;
    case ParticlePhase::wake:
      unit->kind = k_unit_wake, unit->name = "granular.wake";
      unit->items = granular_rest_items(g);
      break;
    case ParticlePhase::drain:
      unit->kind = k_unit_drain, unit->name = "granular.drain";
      unit->items = granular_drain_items(g);
      break;
    case ParticlePhase::rest:
      unit->kind = k_unit_rest, unit->name = "granular.rest";
      unit->items = granular_rest_items(g);
      break;
    case ParticlePhase::stabilise:
      unit->kind = k_unit_stabilise, unit->name = "granular.stabilise";
      break;
    default:
      unit->kind = k_unit_solve, unit->name = "granular.solve";
      break;
  }
  return true;
}

void enter_passes(Granular* g) {
  g->phase = g->desc.reference.stabilisation_iterations != 0 ? ParticlePhase::stabilise : ParticlePhase::solve;
  g->cursor = g->pass = 0;
  g->extent.speed_squared = 0.0f;
  g->extent.quarantined = g->extent.touched = 0;
  for (int k = 0; k < 3; ++k) {
    g->extent.low[k] = g->extent.displacement_low[k] = 3e38f;
    g->extent.high[k] = g->extent.displacement_high[k] = -3e38f;
  }
}

void begin_substep(Granular* g, uint32_t level) {
  if (g->interval_left == 0 && g->emitter_count != 0) granular_emit(g, interval_for(*g, level));
  const Plan plan = plan_substep(*g, level);
  if (g->interval_left == 0) g->interval_owed = g->owed - plan.interval;
  g->interval_left = plan.count;
  g->substep = plan.substep;
  g->iterations = rung_iterations(k_ladder[level], g->desc.reference.solver_iterations);
  // Seconds between the end of this sub-step and the end of the frame, where the colliders' poses are given.
  const double after = g->owed - static_cast<double>(g->substep);
  colliders_pose(g->colliders, g->solid_count, after > 0.0 ? static_cast<float>(after) : 0.0f, g->substep_colliders);
  if (!plan.stale) return enter_passes(g);
  const float reach = (2.0f + g->desc.list_skin) * g->desc.particle_radius;
  cell_sort_begin(&g->particle_sort, reach, g->low, g->high, 2);
  g->phase = ParticlePhase::sort;
}

void run_sort(Granular* g) {
  const SortTarget target = {as_records(g->records[1]), {g->positions[0], g->positions[1], g->positions[2]}, false};
  cell_sort_run(&g->particle_sort, *g->kernels, as_records(g->records[0]), g->particle_count, g->unit, target);
  if (g->particle_sort.phase != k_sort_done) return;
  Particle* sorted = g->records[1];
  g->records[1] = g->records[0];
  g->records[0] = sorted;
  g->phase = ParticlePhase::lists;
  g->cursor = 0;
}

// Lists for the groups with an awake particle; what sleeps is carried into the other buffers as it is.
struct ListTask {
  Granular* g;
  ListArgs args;
  uint32_t dropped[8], awake[8];

  bool settle_group(uint32_t group, uint32_t* awake_lanes) const {
    const uint32_t first = group * k_lane_group;
    uint32_t lanes = 0;
    for (uint32_t i = first; i < first + k_lane_group; ++i) {
      const Particle& p = g->records[0][i];
      lanes += is_awake(p) ? 1u : 0u;
      if (g->body_count != 0 && in_body(p) && !is_inert(p)) g->body_rows[g->rest[number_of(p)].body_slot] = i;
    }
    *awake_lanes += lanes;
    g->group_states[group] = lanes != 0 ? GroupState::active : GroupState::asleep;
    if (lanes != 0) return true;
    for (uint32_t b = 1; b < 3; ++b) {
      if (g->records[b] != nullptr)
        __builtin_memcpy(g->records[b] + first, g->records[0] + first, k_lane_group * sizeof(Particle));
    }
    return false;
  }

  void run(uint32_t piece, uint32_t begin, uint32_t end) {
    uint32_t from = begin, lost = 0, lanes = 0;
    for (uint32_t i = begin; i < end; i += k_lane_group) {
      if (settle_group(i / k_lane_group, &lanes)) continue;
      if (from < i) g->kernels->neighbour_lists(&args, from, i, &lost), dropped[piece] += lost;
      from = i + k_lane_group;
    }
    if (from < end) g->kernels->neighbour_lists(&args, from, end, &lost), dropped[piece] += lost;
    awake[piece] = lanes;
  }
};

ListArgs list_args(const Granular& g) {
  const float reach = (2.0f + g.desc.list_skin) * g.desc.particle_radius;
  ListArgs args = {};
  args.grid = g.particle_sort.grid;
  args.boundary_grid = g.boundary_sort.grid;
  for (int k = 0; k < 3; ++k) args.positions[k] = g.positions[k], args.boundary_positions[k] = g.boundary_positions[k];
  args.boundary_count = g.boundary_count;
  args.boundary_first = g.particle_rows;
  args.inert = g.inert;
  args.reach_squared = reach * reach;
  const float near = k_near_radii * g.desc.particle_radius;
  args.near_squared = near * near;
  args.lists = g.lists;
  args.counts = g.counts;
  return args;
}

void run_lists(Granular* g) {
  ListTask task = {g, list_args(*g), {}, {}};
  if (g->cursor == 0) g->awake_count = 0;
  const uint32_t end = g->particle_count - g->cursor < g->unit ? g->particle_count : g->cursor + g->unit;
  granular_split(*g, g->cursor, end, &task);
  for (const uint32_t dropped : task.dropped) g->dropped_contacts += dropped;
  for (const uint32_t awake : task.awake) g->awake_count += awake;
  g->cursor = end;
  if (end < g->particle_count) return;
  g->lists_valid = true;
  g->waking_count = 0;
  g->list_slack = g->desc.list_skin * g->desc.particle_radius;
  ++g->list_builds;
  granular_collect_groups(g);
  enter_passes(g);
}

struct PassTask {
  contact_solve_function kernel;
  ContactArgs args;
  ContactExtent extents[8];
  void run(uint32_t piece, uint32_t begin, uint32_t end) { kernel(&args, begin, end, &extents[piece]); }
};

void merge_extent(ContactExtent* into, const ContactExtent& from) {
  into->speed_squared = from.speed_squared > into->speed_squared ? from.speed_squared : into->speed_squared;
  into->quarantined += from.quarantined;
  into->touched |= from.touched;
  for (int k = 0; k < 3; ++k) {
    into->low[k] = from.low[k] < into->low[k] ? from.low[k] : into->low[k];
    into->high[k] = from.high[k] > into->high[k] ? from.high[k] : into->high[k];
    into->displacement_low[k] =
        from.displacement_low[k] < into->displacement_low[k] ? from.displacement_low[k] : into->displacement_low[k];
    into->displacement_high[k] =
        from.displacement_high[k] > into->displacement_high[k] ? from.displacement_high[k] : into->displacement_high[k];
  }
}

// The last pass has written records[1]: that is the state now.
void finish_substep(Granular* g) {
  Particle* state = g->records[1];
  g->records[1] = g->records[0];
  g->records[0] = state;
  g->quarantined += g->extent.quarantined;
  g->speed_max = __builtin_sqrtf(g->extent.speed_squared);
  const bool all = g->awake_count == g->particle_count;  // sleepers hold the bounds where they were
  for (int k = 0; k < 3; ++k) {
    if (g->extent.low[k] > g->extent.high[k]) continue;
    if (all || g->extent.low[k] < g->low[k]) g->low[k] = g->extent.low[k];
    if (all || g->extent.high[k] > g->high[k]) g->high[k] = g->extent.high[k];
  }
  g->last_spread = spread_of(*g, g->extent);
  g->last_substep = g->substep;
  g->list_slack -= 2.0f * g->last_spread;
  --g->interval_left;
  ++g->substeps;
  g->dither += k_dither_stride;
  g->simulated += static_cast<double>(g->substep);
  if (g->grain_count != 0) g->unswept += static_cast<double>(g->substep);
  g->owed -= static_cast<double>(g->substep);
  if (g->interval_left == 0) {
    // Rounding of the parts does not accumulate: what was meant is what is owed.
    g->simulated += g->owed - g->interval_owed;
    g->owed = g->interval_owed;
    if (g->owed < k_time_resolution) g->owed = 0.0;
  }
  g->wake_due = g->extent.touched != 0;
  if (g->simulated >= g->next_rest - k_time_resolution) {
    g->rest_due = g->desc.sleep_after > 0.0f;
    g->drain_due = g->sink_count != 0;
    g->next_rest = g->simulated + k_rest_period;
  }
  granular_settle(g);
}

// Buffers a pass reads and writes. The first reads the state; the last writes records[1], which then becomes the state.
void pass_buffers(const Granular& g, uint32_t pass, uint32_t passes, const Particle** in, Particle** out) {
  const uint32_t after = passes - 1 - pass;  // passes that follow
  *out = g.records[after % 2 == 0 ? 1 : 2];
  *in = pass == 0 ? g.records[0] : g.records[after % 2 == 0 ? 2 : 1];
}

void run_pass(Granular* g) {
  const bool solve = g->phase == ParticlePhase::solve;
  const uint32_t stabilisations = g->desc.reference.stabilisation_iterations;
  const uint32_t pass = solve ? stabilisations + g->pass : g->pass;
  const uint32_t passes = stabilisations + g->iterations;
  const float dt = g->substep;
  PassTask task = {};
  task.kernel = solve ? g->kernels->contact_solve : g->kernels->contact_stabilise;
  ContactArgs& a = task.args;
  pass_buffers(*g, pass, passes, &a.in, &a.out);
  a.groups = g->active_groups;
  a.lists = g->lists;
  a.counts = g->counts;
  a.particle_count = g->particle_count;
  a.radius = g->desc.particle_radius;
  a.diameter = 2.0f * g->desc.particle_radius;
  a.static_friction = g->desc.static_friction;
  a.kinetic_friction = g->desc.kinetic_friction;
  a.relaxation = g->desc.reference.relaxation;
  a.averaged = g->desc.reference.scheme == SANDGLASS_SCHEME_AVERAGED ? 1 : 0;
  const float k = g->gravity_length > 0.0f ? g->desc.height_weighting : 0.0f;
  a.weight_linear = -0.25f * k;
  a.weight_cubic = k * k * k * (1.0f / 48.0f);
  a.lift_max = k_lift_gravities * g->gravity_length * dt * dt / static_cast<float>(g->iterations);
  a.inverse_relaxation = 1.0f / g->desc.reference.relaxation;
  const float heaviest =
      g->densest_body < 1.0f ? 1.0f : (g->densest_body < k_heaviest_counted ? g->densest_body : k_heaviest_counted);
  a.separation_max = a.averaged != 0 ? 1e6f : k_separation_units * heaviest * granular_speed_scale(*g) * dt;
  const bool first = solve && g->pass == 0;
  a.scale = first ? dt : 1.0f;
  const float dithered = 1.0f + k_dither * (static_cast<float>(static_cast<int32_t>(g->dither)) * 0x1p-31f);
  for (int c = 0; c < 3; ++c) {
    a.up[c] = g->gravity_length > 0.0f ? -g->gravity[c] / g->gravity_length : 0.0f;
    a.gravity[c] = first ? dithered * g->gravity[c] * dt * dt : 0.0f;
  }
  a.last = solve && g->pass + 1 == g->iterations ? 1 : 0;
  a.step = dt;
  a.displacement_max = g->desc.courant * g->desc.particle_radius;
  a.colliders = g->substep_colliders;
  a.collider_count = g->solid_count;
  a.wake_displacement = granular_wake_speed(*g) * dt;
  a.touched = g->touched;
  a.bodies = g->body_count != 0 ? 1 : 0;

  const uint32_t items = active_items(*g);
  const uint32_t end = items - g->cursor < g->unit ? items : g->cursor + g->unit;
  for (ContactExtent& e : task.extents) e = g->extent, e.quarantined = e.touched = 0;
  granular_split(*g, g->cursor, end, &task);
  if (a.last != 0) {
    for (const ContactExtent& e : task.extents) merge_extent(&g->extent, e);
  }
  g->cursor = end;
  if (end < items) return;

  g->cursor = 0;
  if (++g->pass < passes_of(*g, g->phase)) return;
  g->pass = 0;
  if (!solve) {
    g->phase = ParticlePhase::solve;
    return;
  }
  if (g->body_count != 0 && granular_begin_bodies(g)) g->phase = ParticlePhase::bodies;
  else finish_substep(g);
}

void run_bodies(Granular* g) {
  if (granular_run_bodies(g)) finish_substep(g);
}

void run(void* state, uint32_t level) {
  Granular* g = static_cast<Granular*>(state);
  g->output_cursor = 0;  // emitters and sinks: what was written is out of date
  if (g->phase == ParticlePhase::idle) {
    if (g->touch_due) granular_settle(g);
    else begin_substep(g, level);
  }
  switch (g->phase) {
    case ParticlePhase::idle:
      break;
    case ParticlePhase::sort:
      return run_sort(g);
    case ParticlePhase::lists:
      return run_lists(g);
    case ParticlePhase::bodies:
      return run_bodies(g);
    case ParticlePhase::touch:
      return granular_run_touch(g);
    case ParticlePhase::wake:
      return granular_run_wake(g);
    case ParticlePhase::rest:
      return granular_run_rest(g);
    case ParticlePhase::drain:
      return granular_run_drain(g);
    case ParticlePhase::wake_lists:
      return granular_run_wake_lists(g);
    default:
      return run_pass(g);
  }
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  if (g.particle_count == 0 || g.owed < k_time_resolution) return 0;
  const uint64_t substeps = substeps_for(g, g.owed, level), count = g.particle_count;
  const uint64_t active = g.lists_valid ? active_items(g) : count;
  const uint64_t builds = static_cast<uint64_t>(g.builds_per_substep * static_cast<float>(substeps)) + 1;
  uint32_t n = 0;
  entries[n++] = {k_unit_particle_sort, builds * 2 * count};
  entries[n++] = {k_unit_lists, builds * active};
  if (g.desc.reference.stabilisation_iterations != 0)
    entries[n++] = {k_unit_stabilise, substeps * g.desc.reference.stabilisation_iterations * active};
  if (g.body_count != 0) entries[n++] = {k_unit_bodies, substeps * 2 * g.body_particle_count};
  entries[n++] = {k_unit_solve,
                  substeps * rung_iterations(k_ladder[level], g.desc.reference.solver_iterations) * active};
  return n;
}

}  // namespace

uint32_t granular_build_lists(Granular* g, uint32_t begin, uint32_t end) {
  const ListArgs args = list_args(*g);
  uint32_t dropped = 0;
  g->kernels->neighbour_lists(&args, begin, end, &dropped);
  return dropped;
}

void granular_abandon_substep(Granular* g) {
  while (g->phase == ParticlePhase::bodies) run_bodies(g);
  if (g->phase == ParticlePhase::sort || g->phase == ParticlePhase::lists) {
    g->lists_valid = false;  // the records may have moved already
    granular_find_body_rows(g);
  }
  g->phase = ParticlePhase::idle;
  g->wake_due = g->rest_due = g->drain_due = false;
}

void granular_begin_frame(Granular* g, const sandglass_frame_input* input) {
  if (g->substeps != 0) {
    const float fresh = static_cast<float>(g->list_builds) / static_cast<float>(g->substeps);
    g->builds_per_substep += 0.25f * (fresh - g->builds_per_substep);
  }
  g->substeps = g->list_builds = g->dropped_contacts = g->quarantined = g->ignored_colliders = 0;
  g->input = input;
  g->output_cursor = 0;

  g->collider_count = 0;
  for (int pass = 0; pass < 2; ++pass) {
    const bool grains_only = pass == 1;
    for (uint32_t c = 0; c < input->collider_count; ++c) {
      if (input->colliders == nullptr) {
        g->ignored_colliders += grains_only ? 0 : 1;
        continue;
      }
      if ((input->colliders[c].grains_only != 0) != grains_only) continue;
      if (g->collider_count == g->desc.collider_capacity ||
          !collider_accept(input->colliders[c], &g->colliders[g->collider_count])) {
        ++g->ignored_colliders;
      } else {
        ++g->collider_count;
      }
    }
    if (!grains_only) g->solid_count = g->collider_count;
  }

  granular_take_flow(g, input);
  granular_find_moved_colliders(g);

  constexpr float k_longest_step = 0.1f;
  const float step = input->time_step > 0.0f ? (input->time_step < k_longest_step ? input->time_step : k_longest_step)
                                             : 0.0f;  // NaN: 0
  g->frame_step = step;
  // Two frames' worth is made up for; what is older is slow motion. An interval under way is never cut short.
  const double most = 2.0 * static_cast<double>(step);
  g->owed += static_cast<double>(step);
  if (g->interval_left == 0) {
    if (step > 0.0f && g->owed > most) g->slipped += g->owed - most, g->owed = most;
  } else {
    g->interval_owed += static_cast<double>(step);
    if (step > 0.0f && g->interval_owed > most) {
      g->slipped += g->interval_owed - most;
      g->owed -= g->interval_owed - most;
      g->interval_owed = most;
    }
  }
  granular_skip_rest(g);
}

Stage granular_particle_stage(Granular* granular) { return {granular, next, run, forecast, k_granular_kinds, 1, 0.6f}; }

}  // namespace sandglass
