// The passes of a sub-step over the particles: what the contact kernels are given, and what they have seen.
#include "runtime/granular/granular.h"

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

// Gravity of a sub-step is varied by this share, to and fro. A fall adds nearly the same increment in every sub-step,
// and its rounding has the same sign as long as the velocity's exponent stays: 5,000 sub-steps drifted by up to 8e-5 of
// the way, varied ones by less than 1e-5 (measured for 40 to 200 sub-steps of 20 ms).
constexpr float k_dither = 1.0f / 1024.0f;

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

// Arrays that a pass reads and writes. The first reads the state; the last writes records[1], which then becomes the
// state; those between alternate.
void choose_arrays(const Granular& g, uint32_t pass, uint32_t passes, ContactArgs* a) {
  Particle* const* records = g.particles.records;
  const uint32_t after = passes - 1 - pass;  // passes that follow
  a->out = records[after % 2 == 0 ? 1 : 2];
  a->in = pass == 0 ? records[0] : records[after % 2 == 0 ? 2 : 1];
}

ContactArgs contact_args(const Granular& g) {
  const Substep& s = g.substep;
  const bool solve = s.phase == SubstepPhase::solve;
  const uint32_t stabilisations = g.desc.reference.stabilisation_iterations;
  const float dt = s.length;
  ContactArgs a = {};
  choose_arrays(g, solve ? stabilisations + s.pass : s.pass, stabilisations + s.iterations, &a);
  a.groups = g.sleep.active_groups;
  a.lists = g.neighbours.lists;
  a.counts = g.neighbours.counts;
  a.particle_count = g.particles.count;
  a.radius = g.desc.particle_radius;
  a.diameter = 2.0f * g.desc.particle_radius;
  a.static_friction = g.desc.static_friction;
  a.kinetic_friction = g.desc.kinetic_friction;
  a.relaxation = g.desc.reference.relaxation;
  a.averaged = g.desc.reference.scheme == SANDGLASS_SCHEME_AVERAGED ? 1 : 0;
  const float k = g.gravity_length > 0.0f ? g.desc.height_weighting : 0.0f;
  a.weight_linear = -0.25f * k;
  a.weight_cubic = k * k * k * (1.0f / 48.0f);
  a.lift_max = k_lift_gravities * g.gravity_length * dt * dt / static_cast<float>(s.iterations);
  a.inverse_relaxation = 1.0f / g.desc.reference.relaxation;
  const float densest = g.bodies.densest;
  const float heaviest = densest < 1.0f ? 1.0f : (densest < k_heaviest_counted ? densest : k_heaviest_counted);
  a.separation_max = a.averaged != 0 ? 1e6f : k_separation_units * heaviest * granular_speed_scale(g) * dt;
  const bool first = solve && s.pass == 0;
  a.scale = first ? dt : 1.0f;
  const float dithered = 1.0f + k_dither * (static_cast<float>(static_cast<int32_t>(s.dither)) * 0x1p-31f);
  for (int c = 0; c < 3; ++c) {
    a.up[c] = g.gravity_length > 0.0f ? -g.gravity[c] / g.gravity_length : 0.0f;
    a.gravity[c] = first ? dithered * g.gravity[c] * dt * dt : 0.0f;
  }
  a.last = solve && s.pass + 1 == s.iterations ? 1 : 0;
  a.step = dt;
  a.displacement_max = g.desc.courant * g.desc.particle_radius;
  a.colliders = g.colliders.substep_frames;
  a.collider_count = g.colliders.substep_count;
  a.wake_displacement = sleep_wake_speed(g) * dt;
  a.touched = g.sleep.touched;
  a.bodies = g.bodies.count != 0 ? 1 : 0;
  return a;
}

}  // namespace

void contacts_begin(Granular* g) {
  ContactExtent& e = g->substep.extent;
  g->substep.cursor = g->substep.pass = 0;
  e.speed_squared = 0.0f;
  e.quarantined = e.touched = 0;
  for (int k = 0; k < 3; ++k) {
    e.low[k] = e.displacement_low[k] = 3e38f;
    e.high[k] = e.displacement_high[k] = -3e38f;
  }
}

bool contacts_run(Granular* g) {
  Substep& s = g->substep;
  PassTask task = {};
  task.kernel = s.phase == SubstepPhase::solve ? g->kernels->contact_solve : g->kernels->contact_stabilise;
  task.args = contact_args(*g);
  const uint32_t items = sleep_active_items(*g);
  const uint32_t end = items - s.cursor < g->unit ? items : s.cursor + g->unit;
  for (ContactExtent& e : task.extents) e = s.extent, e.quarantined = e.touched = 0;
  granular_split(*g, s.cursor, end, &task);
  if (task.args.last != 0) {
    for (const ContactExtent& e : task.extents) merge_extent(&s.extent, e);
  }
  s.cursor = end;
  return end >= items;
}

}  // namespace sandglass
