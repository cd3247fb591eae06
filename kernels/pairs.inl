// One Gauss-Seidel pass over contacts in pairs (correction to Alg. 4). A pair is solved once, and both its particles are
// corrected at once. The next pair that one of them takes part in sees that. Pairs of one range have no particle in
// common, so their order within it does not count, nor does the number of lanes.
//
// Three kernels make a sub-step: predict_motion, contact_pairs over every range, complete_motion. In between a particle
// holds its position at the start of the sub-step and its displacement since then, as between Jacobi passes
// (contact.inl).

static void predict_motion(const PredictArgs* a, uint32_t begin, uint32_t end, uint32_t* unused) {
  (void)unused;
  const StepTerms terms = step_terms(a);
  for (uint32_t item = begin; item < end; item += k_width) {
    const uint32_t i = a->groups[item / k_lane_group] * k_lane_group + item % k_lane_group;
    Float r[k_record_floats];
    load_records(floats_of(a->in + i), r);
    const Float pull = keep(broadcast(0.0f) < r[k_mobility], broadcast(1.0f));  // gravity acts on what moves
    for (int k = 0; k < 3; ++k) r[k_vx + k] = terms.scale * r[k_vx + k] + terms.gravity[k] * pull;
    store_records(floats_of(a->out + i), r);
  }
}

// What height weighting adds to the share of the first particle of a pair: see height_share. It lifts both particles.
// Each contact of a tower would then lift what is above it. So the lift only brakes a fall: it ends where the pair
// rises, on average, by as much as gravity takes in a sub-step (lift_max).
SANDGLASS_INLINE Float pair_lift(const ContactLaw* a, const Float* self, const Float* relative, const Float normal[3],
                                 Float overlap, Float share, Float first_mass, Float second_mass) {
  const Float zero = broadcast(0.0f), half = broadcast(0.5f), one = broadcast(1.0f), tiny = broadcast(1e-30f);
  const Float up[3] = {broadcast(a->up[0]), broadcast(a->up[1]), broadcast(a->up[2])};
  const Float more = height_share(a, normal[0], normal[1], normal[2]);
  const Float mine = first_mass * (half + more), others = second_mass * (half - more);
  const Float lift = mine / maximum(mine + others, tiny) - share;
  const Float rise = overlap * (lift * dot3(normal[0], normal[1], normal[2], up[0], up[1], up[2]));
  const Float so_far = dot3(self[k_vx] + half * relative[k_vx], self[k_vy] + half * relative[k_vy],
                            self[k_vz] + half * relative[k_vz], up[0], up[1], up[2]);
  const Float room = maximum(broadcast(a->lift_max) - so_far, zero);
  return lift * select(room < rise, room / maximum(rise, tiny), one);
}

// The lift of a pair adds momentum along its normal. Of pairs with a body only the upright part is kept: sand that is
// caught between particles of a body would drive it over the floor, at metres a second.
SANDGLASS_INLINE void level_lift(const ContactLaw* a, Mask of_body, const Float normal[3], Float lift, Float mine[3],
                                 Float others[3]) {
  const Float up[3] = {broadcast(a->up[0]), broadcast(a->up[1]), broadcast(a->up[2])};
  const Float rise = dot3(normal[0], normal[1], normal[2], up[0], up[1], up[2]);
  for (int k = 0; k < 3; ++k) {
    const Float aside = keep(of_body, lift * (normal[k] - rise * up[k]));
    mine[k] = mine[k] + aside;
    others[k] = others[k] + aside;
  }
}

// Marks the groups of some particles. One copy: it is rare.
SANDGLASS_NOINLINE void mark_groups(const ContactLaw* a, Mask which, const uint32_t* particles, uint32_t* touched) {
  alignas(64) float flags[k_lane_group];
  store(flags, keep(which, broadcast(1.0f)));
  for (uint32_t l = 0; l < k_width; ++l) {
    // Other threads may mark the same group.
    if (flags[l] != 0.0f) __atomic_store_n(&a->touched[particles[l] / k_lane_group], uint8_t{1}, __ATOMIC_RELAXED);
  }
  *touched = 1;
}

// Marks the groups of particles that run into a sleeper faster than the wake speed, as far as this pass can tell.
SANDGLASS_INLINE void note_sleepers(const ContactLaw* a, Mask wakes, const uint32_t* mover, const Float* moved,
                                    uint32_t* touched) {
  const Float limit = broadcast(a->wake_displacement * a->wake_displacement);
  const Mask fast = wakes & (limit < dot3(moved[0], moved[1], moved[2], moved[0], moved[1], moved[2]));
  if (any(fast)) mark_groups(a, fast, mover, touched);
}

// What is the same for all pairs of a pass.
struct PairTerms {
  ContactTerms contact;
  Float inverse_relaxation, separation_max, stick;
};

// Pairs of one range that touch. A pass goes over many that do not: most vectors would hold one or two that do.
struct Touching {
  static constexpr uint32_t k_capacity = 4 * k_lane_group;
  alignas(64) uint32_t first[k_capacity + k_width], second[k_capacity + k_width];  // with room for compress_store
  uint32_t count;
};

// What bodies change of pairs: a body's own particles do not touch. Returns the lanes in which a particle is of a body.
SANDGLASS_INLINE Mask regard_bodies(const float* particles, const uint32_t* second, const Float* self,
                                    Float* others_mobility, Mask* touch) {
  Float other[k_record_floats];
  load_records(particles, second, 1, other);
  *others_mobility = other[k_mobility];
  *touch = and_not(*touch, same_body(self[k_identity], other[k_identity]));
  const Int bodies = as_int(self[k_identity]) | as_int(other[k_identity]);
  return and_not(*touch, (bodies & broadcast(static_cast<int32_t>(k_body_mask))) == broadcast(0));
}

// One vector of pairs that touch: the first `count` lanes.
template <bool k_fixed>
SANDGLASS_INLINE void solve_pairs(const PairArgs* args, const PairTerms& t, const uint32_t* first,
                                  const uint32_t* second, uint32_t count, uint32_t* touched) {
  const ContactLaw* a = &args->law;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), tiny = broadcast(1e-30f);
  float* particles = floats_of(args->particles);
  Float r[k_record_floats];  // of the second particle relative to the first
  load_differences(particles, first, second, r);
  const Float ex = r[k_x] + r[k_vx], ey = r[k_y] + r[k_vy], ez = r[k_z] + r[k_vz];
  const Float d2 = dot3(ex, ey, ez, ex, ey, ez);
  Mask touch = lane_index() < broadcast(static_cast<int32_t>(count));
  Float self[k_record_floats];
  load_records(particles, first, 1, self);
  Float others_mobility = self[k_mobility] + r[k_mobility];
  const Mask of_body = a->bodies != 0 ? regard_bodies(particles, second, self, &others_mobility, &touch) : zero < zero;
  const Float my_mass = maximum(self[k_mobility], zero);  // inverse masses; sleepers do not yield
  const Float others_mass = k_fixed ? zero : maximum(others_mobility, zero);
  const Float masses = my_mass + others_mass;
  touch = touch & (zero < masses);
  if (!any(touch)) return;

  const Float d = square_root(maximum(d2, tiny)), inverse = one / d;
  Float n[3] = {ex * inverse, ey * inverse, ez * inverse};
  const Mask coincident = touch & (d2 < broadcast(1e-24f));
  if (any(coincident)) part_coincident(first, second, 1, coincident, &n[0], &n[1], &n[2]);
  // The speed at which an overlap drives a pair apart is limited; the rest of the overlap goes in later sub-steps.
  const Float along = dot3(r[k_vx], r[k_vy], r[k_vz], n[0], n[1], n[2]);
  const Float overlap = maximum(d - t.contact.diameter, t.inverse_relaxation * minimum(along - t.separation_max, zero));
  const Float slip[3] = {t.stick * (r[k_vx] - along * n[0]), t.stick * (r[k_vy] - along * n[1]),
                         t.stick * (r[k_vz] - along * n[2])};
  const Float grip =
      t.contact.omega *
      friction_grip(t.contact.friction, dot3(slip[0], slip[1], slip[2], slip[0], slip[1], slip[2]), overlap, touch);
  const Float share = k_fixed ? one : my_mass / maximum(masses, tiny), others_share = one - share;
  Float lift = zero;
  if (!k_fixed && a->weight_linear != 0.0f) lift = pair_lift(a, self, r, n, overlap, share, my_mass, others_mass);
  // What the particles' displacements lose. `overlap` is negative.
  const Float push = t.contact.omega * overlap;
  Float mine[3], others[3];
  for (int k = 0; k < 3; ++k) {
    const Float normal = push * n[k], tangential = grip * slip[k];
    mine[k] = zero - keep(touch, (share + lift) * normal + share * tangential);
    others[k] = keep(touch, (others_share - lift) * normal + others_share * tangential);
  }
  if (!k_fixed && a->bodies != 0) level_lift(a, of_body, n, lift * push, mine, others);
  subtract_displacements(particles, first, mine);
  if (!k_fixed) subtract_displacements(particles, second, others);

  if (k_fixed) return;
  const Mask sleeps = self[k_mobility] < zero, other_sleeps = others_mobility < zero;
  if (!any(touch & (sleeps | other_sleeps))) return;
  const Float other_moved[3] = {self[k_vx] + r[k_vx], self[k_vy] + r[k_vy], self[k_vz] + r[k_vz]};
  note_sleepers(a, touch & other_sleeps, first, self + k_vx, touched);
  note_sleepers(a, touch & sleeps, second, other_moved, touched);
}

// Solves whole vectors and keeps the rest; at the end, the rest too.
template <bool k_fixed>
SANDGLASS_NOINLINE void solve_touching(const PairArgs* args, const PairTerms& t, Touching* pairs, bool all,
                                       uint32_t* touched) {
  const uint32_t count = pairs->count;
  // Behind the last pair come copies of it that do nothing.
  for (uint32_t at = count; at % k_width != 0; ++at) {
    pairs->first[at] = pairs->first[at - 1];
    pairs->second[at] = pairs->second[at - 1];
  }
  const uint32_t end = all ? count : count / k_width * k_width;
  for (uint32_t at = 0; at < end; at += k_width)
    solve_pairs<k_fixed>(args, t, pairs->first + at, pairs->second + at, count - at, touched);
  if (all) return;
  store(pairs->first, load(pairs->first + end));
  store(pairs->second, load(pairs->second + end));
  pairs->count = count - end;
}

static void contact_pairs(const PairArgs* args, uint32_t begin, uint32_t end, uint32_t* touched) {
  const PairTerms terms = {contact_terms(&args->law), broadcast(args->inverse_relaxation),
                           broadcast(args->separation_max), broadcast(args->stick)};
  Touching pairs;
  pairs.count = 0;
  const auto solve = [&](bool all) {
    if (args->fixed != 0) solve_touching<true>(args, terms, &pairs, all, touched);
    else solve_touching<false>(args, terms, &pairs, all, touched);
  };
  *touched = 0;
  for (uint32_t pair = begin; pair < end; pair += k_lane_group) {
    const uint32_t group = args->groups[pair / k_lane_group] * k_lane_group;
    const uint32_t *first = args->first + group, *second = args->second + group;
    uint32_t count = pairs.count;
    for (const uint32_t* const behind = first + k_lane_group; first < behind; first += k_width, second += k_width) {
      Float approach[3];
      load_approaches(floats_of(args->particles), first, second, approach);
      const Mask touch =
          dot3(approach[0], approach[1], approach[2], approach[0], approach[1], approach[2]) < terms.contact.diameter2;
      if (__builtin_expect(!any(touch), 1)) continue;
      compress_store(pairs.first + count, load(first), touch);
      count += compress_store(pairs.second + count, load(second), touch);
    }
    pairs.count = count;
    if (count >= Touching::k_capacity - k_lane_group) solve(false);
  }
  if (pairs.count != 0) solve(true);
}

static void complete_motion(const CompleteArgs* a, uint32_t begin, uint32_t end, ContactExtent* extent) {
  const Float zero = broadcast(0.0f);
  const FrictionTerms terms = friction_terms(a);
  ContactExtrema seen = no_extrema();
  for (uint32_t item = begin; item < end; item += k_width) {
    const uint32_t i = a->groups[item / k_lane_group] * k_lane_group + item % k_lane_group;
    Float self[k_record_floats];
    load_records(floats_of(a->in + i), self);
    Float position[3] = {self[k_x], self[k_y], self[k_z]};
    Float move[3] = {self[k_vx], self[k_vy], self[k_vz]};
    leave_colliders<true>(a, terms, position, move);
    const Mask inside =
        lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->particle_count));
    (void)put_moved(a, i, self, inside & (zero < self[k_mobility]), move, &seen);
  }
  put_extrema(seen, extent);
}
