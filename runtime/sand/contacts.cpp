// The passes of a sub-step over the particles: what the contact kernels are given, and what they have seen.
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

// What height weighting may lift a particle by in a sub-step of the source's scheme, in units of what gravity takes from
// it. One unit carries a pile; the second brakes what falls onto it. Without a limit every contact of a tower lifts what
// is above it: a hundred particles that touched when gravity began rose to twice their height. Pairs need a limit on
// what is lifted instead (pairs.inl).
constexpr float k_lift_gravities = 2.0f;

// Speed of separation that an overlap of a pair may cause, in units of sqrt(g d). Contacts by position turn an overlap o
// into a speed of omega o / dt, a metre a second for a tenth of a radius: close-packed bodies bounced off the floor. Piles
// need n g dt to carry n layers, and stay far below the limit up to 100 of them.
constexpr float k_separation_units = 0.9f;

// The share of a pair's speed of separation that a particle may leave a collider with, besides the collider's own
// velocity. Under dense bodies it is times the square of the density that counts: else what they press into a collider
// never comes to rest.
constexpr float k_leave_share = 0.25f;

// Sand under a heavy body carries its weight as so many layers more, up to a density ratio of this: sand that may be
// driven apart faster is thrown about by bodies a thousand times as dense.
constexpr float k_heaviest_counted = 5.0f;

// Friction of a pair that sticks takes a part of the slip in a sub-step. Taken whole, it answers what other pairs of the
// same particles are about to undo: at a coefficient of 0.3 the walls of a tube then bear less (load added 0.36 against
// 0.17 of the weight), and particles overlap more. But the part bounds what friction does however rough the sand is: with
// one part for all, piles grow no steeper above a coefficient of 0.6. So from there on it grows with the coefficient.
constexpr float k_stick = 0.25f, k_stick_friction = 0.6f;

// Gravity of a sub-step is varied by this share, to and fro. A fall adds nearly the same increment in every sub-step,
// and its rounding has the same sign as long as the velocity's exponent stays: 5,000 sub-steps drifted by up to 8e-5 of
// the way, varied ones by less than 1e-5 (measured for 40 to 200 sub-steps of 20 ms).
constexpr float k_dither = 1.0f / 1024.0f;
// 2^32 over the golden ratio: every stretch of the sequence averages to nothing.
constexpr uint32_t k_dither_stride = 2654435769u;

// A pass over particles.
template <class Args, class Result>
struct Pass {
  void (*kernel)(const Args* args, uint32_t begin, uint32_t end, Result* result);
  Args args;
  Result results[k_pieces];
  void run(uint32_t piece, uint32_t begin, uint32_t end) { kernel(&args, begin, end, &results[piece]); }
};

// Runs a unit of it. True once the pass is complete.
template <class Args, class Result>
bool run_unit(const Granular& g, uint32_t* cursor, Pass<Args, Result>* pass) {
  const uint32_t items = sleep_active_items(g);
  const uint32_t end = items - *cursor < g.unit ? items : *cursor + g.unit;
  granular_split(g, *cursor, end, pass);
  *cursor = end;
  return end >= items;
}

struct PairTask {
  contact_pairs_function kernel;
  PairArgs args;
  uint32_t touched[k_pieces];
  void run(uint32_t piece, uint32_t begin, uint32_t end) {
    uint32_t some = 0;
    kernel(&args, begin, end, &some);
    touched[piece] |= some;
  }
};

float sticking_share(float friction) {
  const float share = k_stick * friction / k_stick_friction;
  return share < k_stick ? k_stick : (share < 1.0f ? share : 1.0f);
}

// The greatest density ratio of a body, as far as it counts.
float heaviest(const Granular& g) {
  const float densest = g.bodies.densest;
  return densest < 1.0f ? 1.0f : (densest < k_heaviest_counted ? densest : k_heaviest_counted);
}

ContactLaw contact_law(const Granular& g) {
  const float dt = g.substep.length;
  ContactLaw a = {};
  a.diameter = 2.0f * g.desc.particle_radius;
  a.static_friction = g.desc.static_friction;
  a.kinetic_friction = g.desc.kinetic_friction;
  a.relaxation = g.desc.reference.relaxation;
  const float k = g.gravity_length > 0.0f ? g.desc.height_weighting : 0.0f;
  a.weight_linear = -0.25f * k;
  a.weight_cubic = k * k * k * (1.0f / 48.0f);
  const float weight = g.gravity_length * dt * dt;
  a.lift_max = solves_pairs(g) ? weight : k_lift_gravities * weight / static_cast<float>(g.contacts.iterations);
  for (int axis = 0; axis < 3; ++axis)
    a.up[axis] = g.gravity_length > 0.0f ? -g.gravity[axis] / g.gravity_length : 0.0f;
  a.bodies = g.bodies.count != 0 ? 1 : 0;
  a.wake_displacement = sleep_wake_speed(g) * dt;
  a.touched = g.sleep.touched;
  return a;
}

// Gravity's displacement in a sub-step along an axis.
float pull_of(const Granular& g, int axis) {
  const float dt = g.substep.length;
  const float dithered = 1.0f + k_dither * (static_cast<float>(static_cast<int32_t>(g.contacts.dither)) * 0x1p-31f);
  return dithered * g.gravity[axis] * dt * dt;
}

// A pass reads one array and writes another. The first reads the state; the last writes records[1], which then becomes
// the state; those between alternate. Pairs are solved in place.
struct Arrays {
  const Particle* in;
  Particle* out;
};
Arrays arrays_of(const Granular& g) {
  const Contacts& c = g.contacts;
  const bool pairs = solves_pairs(g), stabilises = g.substep.phase == SubstepPhase::stabilise;
  const uint32_t stabilisations = g.desc.reference.stabilisation_iterations;
  const uint32_t pass = stabilises ? c.pass : stabilisations + (pairs ? 0 : c.pass);
  const uint32_t after = stabilisations + (pairs ? 1 : c.iterations) - 1 - pass;  // passes that follow
  Particle* const* records = g.particles.records;
  return {pass == 0 ? records[0] : records[after % 2 == 0 ? 2 : 1], records[after % 2 == 0 ? 1 : 2]};
}

PredictArgs predict_args(const Granular& g) {
  const Arrays arrays = arrays_of(g);
  PredictArgs a = {arrays.in, arrays.out, g.sleep.active_groups, g.substep.length, {}};
  for (int axis = 0; axis < 3; ++axis) a.gravity[axis] = pull_of(g, axis);
  return a;
}

CompleteArgs complete_args(const Granular& g, const Particle* in, Particle* out) {
  CompleteArgs a = {};
  a.in = in;
  a.out = out;
  a.groups = g.sleep.active_groups;
  a.particle_count = g.particles.count;
  a.radius = g.desc.particle_radius;
  a.static_friction = g.desc.static_friction;
  a.kinetic_friction = g.desc.kinetic_friction;
  a.step = g.substep.length;
  a.displacement_max = g.desc.courant * g.desc.particle_radius;
  a.leave_max = heaviest(g) * heaviest(g) * contacts_leave_speed(g) * g.substep.length;
  a.departed = g.departed.count != 0 ? 1 : 0;
  a.colliders = g.colliders.substep_frames;
  a.collider_count = g.colliders.substep_count;
  return a;
}

AveragedArgs averaged_args(const Granular& g) {
  const bool solves = g.substep.phase == SubstepPhase::solve, first = solves && g.contacts.pass == 0;
  const Arrays arrays = arrays_of(g);
  AveragedArgs a = {};
  a.law = contact_law(g);
  a.end = complete_args(g, arrays.in, arrays.out);
  a.lists = g.neighbours.lists;
  a.counts = g.neighbours.counts;
  a.scale = first ? g.substep.length : 1.0f;
  for (int axis = 0; axis < 3; ++axis) a.gravity[axis] = first ? pull_of(g, axis) : 0.0f;
  a.last = solves && g.contacts.pass + 1 == g.contacts.iterations ? 1 : 0;
  return a;
}

PairArgs pair_args(const Granular& g) {
  PairArgs a = {};
  a.law = contact_law(g);
  a.particles = g.particles.records[1];
  a.first = g.colours.first;
  a.second = g.colours.second;
  a.groups = g.colours.groups;
  a.inverse_relaxation = 1.0f / g.desc.reference.relaxation;
  a.separation_max = k_separation_units * heaviest(g) * granular_speed_scale(g) * g.substep.length;
  a.stick = sticking_share(g.desc.static_friction);
  return a;
}

// A unit of a pass that may be the last one. What it sees counts then.
template <class Args>
bool run_seeing(Contacts* c, const Granular& g, uint32_t* cursor, Pass<Args, ContactExtent>* pass, bool last) {
  for (ContactExtent& e : pass->results) {
    e = c->extent;
    e.quarantined = e.touched = 0;
  }
  const bool done = run_unit(g, cursor, pass);
  for (uint32_t piece = 0; last && piece < k_pieces; ++piece) contacts_include(c, pass->results[piece]);
  return done;
}

}  // namespace

float contacts_leave_speed(const Granular& g) { return k_leave_share * k_separation_units * granular_speed_scale(g); }

bool solves_pairs(const Granular& g) { return g.desc.reference.scheme == SANDGLASS_SCHEME_SMALL_STEP; }

void contacts_reset(Contacts* c) {
  contacts_forget(c);
  c->dither = 0;
}

void contacts_restore(Contacts* c, const SavedScene& s) { c->dither = s.state.dither; }

void contacts_forget(Contacts* c) { c->pass = 0; }

void contacts_begin(Contacts* c, uint32_t iterations) { c->iterations = iterations; }

void contacts_clear_extent(Contacts* c) {
  c->pass = 0;
  c->extent = k_extent_of_none;
}

void contacts_include(Contacts* c, const ContactExtent& from) {
  ContactExtent* into = &c->extent;
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

bool contacts_run(Contacts* c, const Granular& g, uint32_t* cursor) {
  if (g.substep.phase == SubstepPhase::predict) {
    Pass<PredictArgs, uint32_t> pass = {g.kernels->predict_motion, predict_args(g), {}};
    return run_unit(g, cursor, &pass);
  }
  if (g.substep.phase == SubstepPhase::complete) {
    Particle* const particles = arrays_of(g).out;
    Pass<CompleteArgs, ContactExtent> pass = {g.kernels->complete_motion, complete_args(g, particles, particles), {}};
    return run_seeing(c, g, cursor, &pass, true);
  }
  const bool solves = g.substep.phase == SubstepPhase::solve;
  Pass<AveragedArgs, ContactExtent> pass = {
      solves ? g.kernels->contact_solve : g.kernels->contact_stabilise, averaged_args(g), {}};
  return run_seeing(c, g, cursor, &pass, pass.args.last != 0);
}

bool contacts_run_pairs(Contacts* c, const Granular& g, uint32_t* cursor) {
  PairTask task = {};
  task.kernel = g.kernels->contact_pairs;
  task.args = pair_args(g);
  // Always in the same order. Every other pass backward makes forces alternate between sub-steps by 15 %. That shakes
  // the sand: friction then carries only what creeps, and the floor of a tube bore 0.72 of the weight, not 0.21.
  const uint32_t all = pair_count(g.colours);
  for (uint32_t left = pair_unit(g.colours, g.unit); left != 0 && *cursor < all;) {
    const PairPiece piece = pair_piece(g.colours, *cursor, left);
    task.args.fixed = piece.fixed ? 1 : 0;
    granular_split(g, piece.begin, piece.end, &task);
    *cursor += piece.end - piece.begin;
    left -= piece.end - piece.begin;
  }
  for (const uint32_t touched : task.touched) c->extent.touched |= touched;
  return *cursor >= all;
}

bool contacts_next_pass(Contacts* c, uint32_t passes) {
  if (++c->pass < passes) return true;
  c->pass = 0;
  return false;
}

void contacts_complete(Contacts* c, FrameCounts* counts) {
  counts->quarantined += c->extent.quarantined;
  ++counts->substeps;
  c->dither += k_dither_stride;
}

}  // namespace sandglass
