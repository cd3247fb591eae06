// One Jacobi pass, as the dissertation has it. Every particle gathers the corrections of its contacts from the positions
// before the pass, by (4.14)-(4.27). It averages them (4.37), and is then pushed out of the colliders
// (collider_push.inl). Where the equations differ from the printed ones, runtime/README.md says why ("Corrections").
// Much of this serves the pairs too (pairs.inl).
//
// A particle holds the position at the start of the sub-step and the displacement since then. Predicted positions are
// never stored (correction to Alg. 4): a relative position is (x_j - x_i) + (displacement_j - displacement_i), exact to
// the last bits of the small quantities. With one iteration the whole sub-step is this one pass.

// Height weighting (correction to 4.38): 1/(1 + exp(k c)) - 1/2 as a cubic of c = n . up, which says how much more than
// half of a correction this particle takes. One side takes more by what the other takes less, so every contact lifts
// the pair. That lift carries the layers above. It must not exceed their weight, or towers jump and impacts throw. So
// the sum that weighting adds to a particle is limited to a multiple of gravity's own displacement (lift_max).
SANDGLASS_INLINE Float height_share(const ContactLaw* a, Float nx, Float ny, Float nz) {
  const Float c = dot3(nx, ny, nz, broadcast(a->up[0]), broadcast(a->up[1]), broadcast(a->up[2]));
  return c * (broadcast(a->weight_linear) + broadcast(a->weight_cubic) * (c * c));
}

struct Direction {
  Float x, y, z;
};

// A unit vector for each pair, chosen by its indices: both sides agree on it. One copy for all kernels.
SANDGLASS_NOINLINE Direction direction_of(const uint32_t* first, const uint32_t* second, uint32_t stride) {
  alignas(64) uint32_t others[k_lane_group];
  for (uint32_t l = 0; l < k_width; ++l) others[l] = second[l * stride];
  const Int i = load(first), j = load(others), sum = i + j, none = broadcast(0);
  const Float side = select(i < j, broadcast(1.0f), broadcast(-1.0f)), other_side = broadcast(0.0f) - side;
  const Mask even = (sum & broadcast(1)) == none, low = (sum & broadcast(2)) == none;
  return {broadcast(0.36f) * select(even, other_side, side), broadcast(0.8f) * side,  // 0.36^2 + 0.8^2 + 0.48^2 = 1
          broadcast(0.48f) * select(low, other_side, side)};
}

// Coincident particles part along a fixed direction.
SANDGLASS_INLINE void part_coincident(const uint32_t* first, const uint32_t* second, uint32_t stride, Mask coincident,
                                      Float* nx, Float* ny, Float* nz) {
  const Direction direction = direction_of(first, second, stride);
  *nx = select(coincident, direction.x, *nx);
  *ny = select(coincident, direction.y, *ny);
  *nz = select(coincident, direction.z, *nz);
}

// Particles of one rigid body do not touch each other: the upper bits of the number name the body.
SANDGLASS_INLINE Mask same_body(Float a, Float b) {
  const Int body = as_int(a) & broadcast(static_cast<int32_t>(k_body_mask));
  return and_not(body == (as_int(b) & broadcast(static_cast<int32_t>(k_body_mask))), body == broadcast(0));
}

// What is the same for all particles of a pass.
struct ContactTerms {
  Float diameter, diameter2;
  Float omega;
  FrictionTerms friction;
};
struct StepTerms {
  Float scale, gravity[3];
};

SANDGLASS_INLINE ContactTerms contact_terms(const ContactLaw* a) {
  ContactTerms t;
  t.diameter = broadcast(a->diameter);
  t.diameter2 = t.diameter * t.diameter;
  t.omega = broadcast(a->relaxation);
  t.friction = friction_terms(a);
  return t;
}

template <class Args>
SANDGLASS_INLINE StepTerms step_terms(const Args* a) {
  StepTerms t;
  t.scale = broadcast(a->scale);
  for (int k = 0; k < 3; ++k) t.gravity[k] = broadcast(a->gravity[k]);
  return t;
}

// What the contacts of a vector of particles add up to.
struct ContactSum {
  Float x, y, z;                 // corrections
  Float lift_x, lift_y, lift_z;  // what height weighting adds to them
  Float contacts;
  Mask wakes;  // touches a sleeper
};

// Where masses differ: a particle's share of a correction and of what lifts it, by inverse mass.
SANDGLASS_INLINE void share_by_mass(Float w, Float others_w, Mask unequal, bool weighted, Float* mine, Float* lift) {
  const Float half = broadcast(0.5f), one = broadcast(1.0f);
  const Float heavy = w * (half + *lift), light = others_w * (half - *lift);
  const Float share = w / select(unequal, w + others_w, one);
  *mine = select(unequal, share, *mine);
  if (weighted) *lift = select(unequal, heavy / select(unequal, heavy + light, one) - share, *lift);
}

// Directions for the particles from i on that lie in another's place.
SANDGLASS_INLINE void part_from(uint32_t i, const uint32_t* others, Mask coincident, Float n[3]) {
  alignas(64) uint32_t own[k_lane_group];
  store(own, lane_index() + broadcast(static_cast<int32_t>(i)));
  part_coincident(own, others, k_list_slots, coincident, &n[0], &n[1], &n[2]);
}

SANDGLASS_INLINE void add_contact(Float x, Float y, Float z, Mask touch, Float others_w, ContactSum* sum) {
  sum->x = sum->x + keep(touch, x);
  sum->y = sum->y + keep(touch, y);
  sum->z = sum->z + keep(touch, z);
  sum->contacts = sum->contacts + keep(touch, broadcast(1.0f));
  sum->wakes = sum->wakes | (touch & (others_w < broadcast(0.0f)));
}

// Goes through the lists of the particles from i on.
template <bool k_solve>
SANDGLASS_INLINE ContactSum gather_contacts(const AveragedArgs* a, const ContactTerms& t, const StepTerms& step,
                                            uint32_t i, const Float* self, Float pull) {
  const Float zero = broadcast(0.0f), half = broadcast(0.5f), one = broadcast(1.0f), tiny = broadcast(1e-30f);
  const Float w = self[k_mobility];
  const Mask moves = zero < w;
  const bool weighted = a->law.weight_linear != 0.0f;
  ContactSum sum = {zero, zero, zero, zero, zero, zero, zero, zero < zero};
  uint32_t slots = 0;
  for (uint32_t l = 0; l < k_width; ++l) slots = a->counts[i + l] > slots ? a->counts[i + l] : slots;
  const uint32_t* row = a->lists + static_cast<uint64_t>(i) * k_list_slots;
  for (uint32_t s = 0; s < slots; ++s) {
    Float other[k_record_floats];
    load_records(floats_of(a->end.in), row + s, k_list_slots, other);
    Float r[3] = {zero, zero, zero}, e[3];  // r: relative displacement (correction to 4.17)
    for (int k = 0; k < 3; ++k) e[k] = other[k] - self[k];
    const Mask free = zero < other[k_mobility];
    if (k_solve) {
      const Float relative_pull = keep(free, one) - pull;
      for (int k = 0; k < 3; ++k) {
        r[k] = step.scale * (other[k_vx + k] - self[k_vx + k]) + step.gravity[k] * relative_pull;
        e[k] = e[k] + r[k];
      }
    }
    const Float d2 = dot3(e[0], e[1], e[2], e[0], e[1], e[2]);
    Mask touch = d2 < t.diameter2;
    if (a->law.bodies != 0) touch = and_not(touch, same_body(self[k_identity], other[k_identity]));
    if (!any(touch)) continue;
    const Float d = square_root(maximum(d2, tiny));  // no lane divides by zero, touching or not
    const Float inverse = one / d;
    Float n[3] = {e[0] * inverse, e[1] * inverse, e[2] * inverse};
    const Mask coincident = touch & (d2 < broadcast(1e-24f));
    if (any(coincident)) part_from(i, row + s, coincident, n);
    const Float overlap = d - t.diameter;               // negative
    Float mine = select(free, half, one), lift = zero;  // all of it against what does not move or is asleep
    if (weighted) lift = height_share(&a->law, n[0], n[1], n[2]);
    const Mask differ = free & ((w < other[k_mobility]) | (other[k_mobility] < w));
    if (a->law.bodies != 0 && any(touch & differ))
      share_by_mass(w, other[k_mobility], moves & differ, weighted, &mine, &lift);
    if (weighted) {
      const Float raised = overlap * keep(free & touch, lift);
      sum.lift_x = sum.lift_x + raised * n[0];
      sum.lift_y = sum.lift_y + raised * n[1];
      sum.lift_z = sum.lift_z + raised * n[2];
    }
    const Float push = mine * overlap;
    Float c[3] = {push * n[0], push * n[1], push * n[2]};
    if (k_solve) {
      const Float along = dot3(r[0], r[1], r[2], n[0], n[1], n[2]);
      const Float tx = mine * (r[0] - along * n[0]), ty = mine * (r[1] - along * n[1]),
                  tz = mine * (r[2] - along * n[2]);
      const Float grip = friction_grip(t.friction, dot3(tx, ty, tz, tx, ty, tz), push, touch);
      c[0] = c[0] + grip * tx;
      c[1] = c[1] + grip * ty;
      c[2] = c[2] + grip * tz;
    }
    add_contact(c[0], c[1], c[2], touch, other[k_mobility], &sum);
  }
  return sum;
}

// The correction that the contacts of a particle give: averaged, with a limit on what height weighting adds.
SANDGLASS_INLINE void weigh_contacts(const ContactLaw* a, Float omega, ContactSum* sum) {
  const Float one = broadcast(1.0f), tiny = broadcast(1e-30f);
  const Float factor = minimum(omega / maximum(sum->contacts, one), one);
  sum->x = factor * sum->x;
  sum->y = factor * sum->y;
  sum->z = factor * sum->z;
  if (a->weight_linear == 0.0f) return;
  const Float lx = factor * sum->lift_x, ly = factor * sum->lift_y, lz = factor * sum->lift_z;
  const Float rise = dot3(lx, ly, lz, broadcast(a->up[0]), broadcast(a->up[1]), broadcast(a->up[2]));
  const Float lift_max = broadcast(a->lift_max);
  const Float part = select(lift_max < rise, lift_max / maximum(rise, tiny), one);
  sum->x = sum->x + part * lx;
  sum->y = sum->y + part * ly;
  sum->z = sum->z + part * lz;
}

// Extrema over the particles that the last pass has moved.
struct ContactExtrema {
  Float speed2;
  Float low[3], high[3], move_low[3], move_high[3];
  uint32_t quarantined;
};

SANDGLASS_INLINE ContactExtrema no_extrema() {
  const float huge = 3e38f;
  ContactExtrema e;
  e.speed2 = broadcast(0.0f);
  for (int k = 0; k < 3; ++k) {
    e.low[k] = e.move_low[k] = broadcast(huge);
    e.high[k] = e.move_high[k] = broadcast(-huge);
  }
  e.quarantined = 0;
  return e;
}

// After a pass of the stabilisation, which moves the start positions only. A move beyond the CFL limit is left out.
SANDGLASS_INLINE void put_stabilised(const CompleteArgs* a, const Float* self, Mask moves, const Float position[3],
                                     Float* out) {
  const Float mx = position[0] - self[k_x], my = position[1] - self[k_y], mz = position[2] - self[k_z];
  const Float m2 = dot3(mx, my, mz, mx, my, mz);
  const Float limit = broadcast(a->displacement_max);
  const Mask calm = (m2 <= limit * limit) & moves;
  for (int k = 0; k < 3; ++k) {
    out[k] = select(calm, position[k], self[k]);
    out[k_vx + k] = self[k_vx + k];
  }
}

// The lanes whose displacement is a number. False for NaN and Inf: their displacement becomes 0.
SANDGLASS_INLINE Mask sound_only(Float move[3]) {
  const Mask sound = dot3(move[0], move[1], move[2], move[0], move[1], move[2]) < broadcast(1e12f);
  for (int k = 0; k < 3; ++k) move[k] = keep(sound, move[k]);
  return sound;
}

// After the last pass: moves the particles from i on, by no more than the CFL limit, and gives them their velocity. The
// limit is not for those that have departed, and the extrema are not of them. Returns the squares of the displacements.
SANDGLASS_INLINE Float put_moved(const CompleteArgs* a, uint32_t i, const Float* self, Mask live, Float move[3],
                                 ContactExtrema* seen) {
  const Mask sound = sound_only(move);
  Float move2 = dot3(move[0], move[1], move[2], move[0], move[1], move[2]);
  Float out[k_record_floats];
  out[k_mobility] = self[k_mobility];
  out[k_identity] = self[k_identity];
  const Float zero = broadcast(0.0f), limit = broadcast(a->displacement_max), step = broadcast(a->step);
  Mask fast = limit * limit < move2, counted = live;
  if (a->departed != 0) {
    const Mask stays = (as_int(self[k_identity]) & broadcast(static_cast<int32_t>(k_departed))) == broadcast(0);
    fast = fast & stays;
    counted = live & stays;
  }
  if (any(fast)) {
    const Float slow = select(fast, limit / square_root(maximum(move2, broadcast(1e-30f))), broadcast(1.0f));
    for (int k = 0; k < 3; ++k) move[k] = move[k] * slow;
    move2 = select(fast, limit * limit, move2);
  }
  for (int k = 0; k < 3; ++k) {
    out[k] = select(live, self[k] + move[k], self[k]);
    // A division: multiplying by 1/dt would err by the same sign in every sub-step.
    out[k_vx + k] = keep(live, move[k] / step);
  }
  // Out of bounds, or not a number: back to where it was, with velocity 0. A coordinate that was no better becomes 0.
  const Float bound = broadcast(k_coordinate_bound);
  const Mask legal = (absolute(out[k_x]) < bound) & (absolute(out[k_y]) < bound) & (absolute(out[k_z]) < bound);
  const Mask bad = and_not(live, sound & legal);
  if (any(bad)) {
    seen->quarantined += count(bad);
    for (int k = 0; k < 3; ++k) {
      const Mask number = absolute(self[k]) < bound;
      out[k] = select(bad, keep(number, self[k]), out[k]);
      out[k_vx + k] = select(bad, zero, out[k_vx + k]);
    }
  }
  seen->speed2 = maximum(keep(counted, move2 / (step * step)), seen->speed2);
  const bool whole = all(counted);
  for (int k = 0; k < 3; ++k) {
    const Float low = minimum(out[k], seen->low[k]), high = maximum(out[k], seen->high[k]);
    const Float move_low = minimum(move[k], seen->move_low[k]), move_high = maximum(move[k], seen->move_high[k]);
    seen->low[k] = whole ? low : select(counted, low, seen->low[k]);
    seen->high[k] = whole ? high : select(counted, high, seen->high[k]);
    seen->move_low[k] = whole ? move_low : select(counted, move_low, seen->move_low[k]);
    seen->move_high[k] = whole ? move_high : select(counted, move_high, seen->move_high[k]);
  }
  store_records(floats_of(a->out + i), out);
  return move2;
}

SANDGLASS_INLINE void put_extrema(const ContactExtrema& seen, ContactExtent* extent) {
  extent->speed_squared = lane_maximum(seen.speed2);
  for (int k = 0; k < 3; ++k) {
    extent->low[k] = lane_minimum(seen.low[k]);
    extent->high[k] = lane_maximum(seen.high[k]);
    extent->displacement_low[k] = lane_minimum(seen.move_low[k]);
    extent->displacement_high[k] = lane_maximum(seen.move_high[k]);
  }
  extent->quarantined = seen.quarantined;
}

template <bool k_solve>
SANDGLASS_INLINE void contact_pass(const AveragedArgs* args, uint32_t begin, uint32_t end, ContactExtent* extent) {
  const ContactLaw* const law = &args->law;
  const CompleteArgs* const a = &args->end;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  const ContactTerms terms = contact_terms(law);
  const StepTerms step = step_terms(args);
  ContactExtrema seen = no_extrema();
  for (uint32_t item = begin; item < end; item += k_width) {
    const uint32_t i = a->groups[item / k_lane_group] * k_lane_group + item % k_lane_group;
    Float self[k_record_floats];
    load_records(floats_of(a->in + i), self);
    const Mask moves = zero < self[k_mobility];
    const Float pull = keep(moves, one);  // gravity acts on what moves
    Float position[3] = {self[k_x], self[k_y], self[k_z]};
    Float move[3] = {zero, zero, zero};  // over the sub-step so far
    for (int k = 0; k_solve && k < 3; ++k) move[k] = step.scale * self[k_vx + k] + step.gravity[k] * pull;

    ContactSum sum = gather_contacts<k_solve>(args, terms, step, i, self, pull);
    weigh_contacts(law, terms.omega, &sum);
    Float* corrected = k_solve ? move : position;
    corrected[0] = corrected[0] + sum.x;
    corrected[1] = corrected[1] + sum.y;
    corrected[2] = corrected[2] + sum.z;
    leave_colliders<k_solve>(a, terms.friction, position, move);

    Float out[k_record_floats];
    out[k_mobility] = self[k_mobility];
    out[k_identity] = self[k_identity];
    if (!k_solve) {
      put_stabilised(a, self, moves, position, out);
      store_records(floats_of(a->out + i), out);
      continue;
    }
    const Mask inside =
        lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->particle_count));
    const Mask live = inside & moves;
    if (args->last != 0) {
      const Float move2 = put_moved(a, i, self, live, move, &seen);
      if (any(sum.wakes & live & (broadcast(law->wake_displacement * law->wake_displacement) < move2))) {
        law->touched[i / k_lane_group] = 1;
        extent->touched = 1;
      }
      continue;
    }
    sound_only(move);
    for (int k = 0; k < 3; ++k) {
      out[k] = self[k];
      out[k_vx + k] = keep(live, move[k]);
    }
    store_records(floats_of(a->out + i), out);
  }
  if (k_solve && args->last != 0) put_extrema(seen, extent);
}

static void contact_stabilise(const AveragedArgs* args, uint32_t begin, uint32_t end, ContactExtent* extent) {
  contact_pass<false>(args, begin, end, extent);
}

static void contact_solve(const AveragedArgs* args, uint32_t begin, uint32_t end, ContactExtent* extent) {
  contact_pass<true>(args, begin, end, extent);
}
