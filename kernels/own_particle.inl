// A grain stays with its own particle: the one that was nearest to it when the sweep began.
//
// The mean motion of the particles around a grain takes it along inside a pile. Outside, means do not: a grain would not
// turn where its particle hits something, nor leave with a particle that leaves its neighbours, and sand would be drawn
// where there is none. So outside a pile's inside, and up to some two particle radii from its particle, of a grain's
// own flight is kept
// * that it sinks slowly towards what carries it;
// * along a falling jet, up to 1.25 times the difference that a steady jet has. In one the speed grows by g / |u| a metre
//   along it, so that a grain that is ahead of its particle is the faster one and the jet does not part into bands. A
//   grain that followed the mean velocities of whole sweeps lags by what half a sweep of gravity adds, and is not pushed
//   forward;
// and all else is that of the particle. About a lone particle it is drawn back from further away, some grains nearer to
// it than others, so that what one particle stands for has a soft edge. Speeds are in units of sqrt(g d), distances in
// particle radii. The constants were chosen with pours and a small hourglass (`sandglass_lab verify follow` has more).

constexpr float k_weight_inside = 2.0f;  // the sum of weights in a pile is about 3

// 1 at a and below, 0 at b and above, smooth between.
SANDGLASS_INLINE Float fade(Float value, float a, float b) {
  const Float t =
      at_most(at_least((broadcast(b) - value) * broadcast(1.0f / (b - a)), broadcast(0.0f)), broadcast(1.0f));
  return t * t * (broadcast(3.0f) - broadcast(2.0f) * t);
}

struct Own {
  Mask known;         // lanes that have a particle, and are outside the pile's inside
  Float velocity[3];  // metres a second, the mean one of the sweep
  Float offset[3];    // metres, from where it began to the grain
  Float free;         // its share of free fall
  Float lone;         // 1: no other particle is within reach; 0: there are several
};

SANDGLASS_INLINE Own nobodys_own() {
  const Float zero = broadcast(0.0f);
  return {zero < zero, {zero, zero, zero}, {zero, zero, zero}, zero, zero};
}

// Arguments in every lane.
struct OwnUnits {
  Float time;                 // seconds of the sweep
  Float speed, per_speed;     // metres a second, sqrt(g d), and its inverse
  Float per_radius;           // of the particles
  Float gravity[3], down[3];  // metres a second squared; its direction
  Float added[3];             // metres a second that gravity adds to the mean velocity of a sweep
};

SANDGLASS_INLINE OwnUnits own_units_of(const RefineArgs* a) {
  const float* g = a->gravity;
  const float strength = __builtin_sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const float time = a->step * static_cast<float>(a->steps), inverse = strength > 0.0f ? 1.0f / strength : 0.0f;
  OwnUnits u = {};
  u.time = broadcast(time);
  u.speed = broadcast(a->speed_scale);
  u.per_speed = broadcast(1.0f / a->speed_scale);
  u.per_radius = broadcast(3.0f / a->support);
  for (int k = 0; k < 3; ++k) {
    u.gravity[k] = broadcast(g[k]);
    u.down[k] = broadcast(inverse * g[k]);
    u.added[k] = broadcast(0.5f * (time + a->step) * g[k]);
  }
  return u;
}

// `numbers`: of the particles in the snapshot. Lanes that `known` does not hold get 0.
SANDGLASS_INLINE void read_own(const RefineArgs* a, const OwnUnits& units, Mask known, Float numbers,
                               const Float position[3], Own* own) {
  alignas(64) uint32_t number[k_lane_group];
  store(number, to_int(keep(known, numbers)));
  const float* particles[k_width];
  for (uint32_t l = 0; l < k_width; ++l) particles[l] = floats_of(a->snapshot + number[l]);
  Float place[4], motion[4];
  load_quads(particles, k_x, place);
  load_quads(particles, k_vx, motion);
  own->known = known;
  for (int k = 0; k < 3; ++k) {
    own->velocity[k] = keep(known, motion[k]);
    own->offset[k] = keep(known, position[k] - (place[k] - units.time * motion[k]));
  }
  own->free = keep(known, place[k_free_fall]);
}

SANDGLASS_INLINE Float dot3(const Float a[3], const Float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// What is left of a grain's flight away from its particle, `away` metres a second: removes that part from it.
SANDGLASS_INLINE void keep_flight(const OwnUnits& units, const Own& own, Float away[3]) {
  const Float zero = broadcast(0.0f), half = broadcast(0.5f);
  const Float speed = square_root(dot3(own.velocity, own.velocity));
  const Mask flies = zero < own.free;
  if (any(flies)) {
    const Float inverse = broadcast(1.0f) / at_least(speed, broadcast(1e-6f));
    const Float falls = own.free * dot3(units.gravity, own.velocity) * inverse;
    const Float lag = half * units.time * maximum(falls, zero), along = dot3(away, own.velocity) * inverse;
    // By its speed when the sweep began. Of what starts to fall nothing is known: the difference is at most half of it.
    const Float began = maximum(speed - lag, half * units.speed), limit = half * speed;
    const Float ahead = dot3(own.offset, own.velocity) * inverse;
    const Float steady = maximum(minimum(broadcast(1.25f) * falls * ahead / began, limit), zero - limit);
    const Float slower = minimum(steady, zero) - lag, faster = maximum(steady, zero);
    const Float stretch = minimum(maximum(along, slower), faster) * inverse;
    for (int k = 0; k < 3; ++k) away[k] = select(flies, away[k] - stretch * own.velocity[k], away[k]);
  }
  // So slowly that it does not fall into a pile on which its particle lands.
  const Float slow = fade(units.per_speed * speed, 0.1f, 0.3f);
  const Float sinks = minimum(maximum(dot3(away, units.down), zero),
                              units.speed * (broadcast(0.01f) + broadcast(0.03f) * slow + broadcast(0.02f) * own.free));
  for (int k = 0; k < 3; ++k) away[k] = away[k] - sinks * units.down[k];
}

// `weight`: the sum at the grain. `number`: of the grain, as its bits. Changes the mean motion that it follows, and its
// own velocity.
SANDGLASS_INLINE void stay_with_own(const OwnUnits& units, const Own& own, Float weight, Float number, Float mean[3],
                                    Float velocity[3]) {
  const Float one = broadcast(1.0f);
  const Float distance = square_root(dot3(own.offset, own.offset)), radii = units.per_radius * distance;
  // It ends where nodes no longer know the particle (k_reach_radii), so that no grain jumps there.
  const Float near = fade(radii, 2.35f, 2.47f);
  Float difference[3], away[3];
  for (int k = 0; k < 3; ++k) {
    difference[k] = own.velocity[k] - mean[k];
    away[k] = velocity[k] + units.added[k] - own.velocity[k];
  }
  keep_flight(units, own, away);
  // Where the particle goes elsewhere than the mean, the grain goes with it.
  const Float parts = near * fade(weight, 0.9f * k_weight_inside, k_weight_inside) *
                      (one - fade(units.per_speed * square_root(dot3(difference, difference)), 0.15f, 0.4f));
  for (int k = 0; k < 3; ++k) {
    mean[k] = select(own.known, mean[k] + parts * difference[k], mean[k]);
    velocity[k] = select(own.known, velocity[k] - near * away[k], velocity[k]);
  }
  const Mask lone = own.known & (broadcast(0.0f) < own.lone);
  if (!any(lone)) return;
  // 0.7 to 1.3, by the last four bits of its number.
  const Float nearer = broadcast(0.7f) + broadcast(0.04f) * to_float(as_int(number) & broadcast(15));
  const Float back = near * own.lone * (one - own.free) * (one - fade(radii * nearer, 1.2f, 1.6f)) * broadcast(0.1f) *
                     units.speed / at_least(distance, broadcast(1e-6f));
  for (int k = 0; k < 3; ++k) velocity[k] = select(lone, velocity[k] - back * own.offset[k], velocity[k]);
}
