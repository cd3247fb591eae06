// Grains are advected by the velocity field of the particles (read_flow.inl), (4.39)-(4.44) of the dissertation,
// blended into free flight near and outside the surface, and kept outside the colliders. Lane = grain.

// The share of free flight in a grain's motion: (4.44), or the continuous rule, which has the same two thresholds and
// passes them without a jump.
SANDGLASS_INLINE Float free_flight(const RefineArgs* a, const Flow& flow) {
  const Float one = broadcast(1.0f), zero = broadcast(0.0f);
  const Mask alone = flow.weight <= zero;
  const Float ratio = flow.largest / select(alone, one, flow.weight);
  Float lambda;
  if (a->source_rule != 0) {
    const Mask sparse = (flow.largest <= broadcast(a->weight_at_radius)) | (broadcast(0.6f) <= ratio);
    lambda = keep(sparse, one - flow.largest);
  } else {
    // In the pile's inside the sum of weights is about 3. There a grain in a gap does not fall: it would clump.
    const Float few = fade(flow.largest, a->weight_at_radius - 0.1f, a->weight_at_radius + 0.1f) *
                      fade(flow.weight, 1.2f, k_weight_inside);
    const Float single = one - fade(ratio, 0.5f, 0.7f);
    // What falls among falling particles falls on its own: they part, and it would stay with the nearest ones.
    const Float falling =
        flow.free / select(alone, one, flow.weight) * fade(flow.weight, 0.8f * k_weight_inside, k_weight_inside);
    lambda = maximum(maximum((one - flow.largest) * few, single), at_most(falling, one));
  }
  return select(alone, one, lambda);
}

// Where the ground is no plane that lies as local y = 0 does.
SANDGLASS_INLINE Mask steep(const ColliderFrame& c, const Float n[3]) {
  constexpr float k_level = 0.999f;  // the cosine of 2.6 degrees
  const float* up = c.axes[1];
  return dot3(n[0], n[1], n[2], broadcast(up[0]), broadcast(up[1]), broadcast(up[2])) < broadcast(k_level);
}

// Returns the lanes that a field moved, or a relief where it is steep: there distances are rough.
SANDGLASS_NOINLINE Mask keep_outside(const RefineArgs* a, const ColliderFrame* colliders, Mask lanes, Float position[3],
                                     Float velocity[3]) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  Mask rough = and_not(lanes, lanes);
  for (uint32_t c = 0; c < a->collider_count; ++c) {
    const ColliderFrame& collider = colliders[c];
    if (far_from(collider, position, a->grain_radius)) continue;
    const Surface surface = collider_surface(collider, position[0], position[1], position[2]);
    const Float depth = broadcast(a->grain_radius) - surface.distance;
    const Mask hit = lanes & (zero < depth);
    if (!any(hit)) continue;
    const Float n[3] = {surface.nx, surface.ny, surface.nz};
    if (collider.shape == SANDGLASS_SHAPE_FIELD) rough = rough | hit;
    if (collider.shape == SANDGLASS_SHAPE_RELIEF) rough = rough | (hit & steep(collider, n));
    Float v[3], relative[3], along = zero;
    collider_velocity(collider, position[0], position[1], position[2], n, v);
    for (int k = 0; k < 3; ++k) {
      position[k] = select(hit, position[k] + depth * n[k], position[k]);
      relative[k] = velocity[k] - v[k];
      along = along + relative[k] * n[k];
    }
    // The inward part of the relative velocity is removed. Coulomb friction reduces the rest.
    const Mask inward = hit & (along < zero);
    Float tangential[3], t2 = zero;
    for (int k = 0; k < 3; ++k) {
      tangential[k] = relative[k] - along * n[k];
      t2 = t2 + tangential[k] * tangential[k];
    }
    const Float speed = square_root(t2);
    const Float left =
        maximum(one - (broadcast(a->friction) * absolute(along)) / maximum(speed, broadcast(1e-12f)), zero);
    for (int k = 0; k < 3; ++k) velocity[k] = select(inward, v[k] + left * tangential[k], velocity[k]);
  }
  return rough;
}

SANDGLASS_INLINE Mask sound_places(Mask lanes, const Float position[3]) {
  const Float limit = broadcast(k_coordinate_bound);
  return lanes & within(position[0], limit) & within(position[1], limit) & within(position[2], limit);
}

// As many grains as there are lanes, during a sweep.
struct Grains {
  Float position[3], velocity[3];
  Float number;  // its bits
  Mask inside;   // lanes that hold a grain
  Mask settled;  // still for long enough, and nothing around them moves: they stay where they are
};

// For what needs them in memory: copied one by one, because compilers leave a struct in memory that is copied whole.
SANDGLASS_INLINE Grains copy_of(const Grains& g) {
  Grains copy;
  for (int k = 0; k < 3; ++k) {
    copy.position[k] = g.position[k];
    copy.velocity[k] = g.velocity[k];
  }
  copy.number = g.number;
  copy.inside = g.inside;
  copy.settled = g.settled;
  return copy;
}

// The flow around grains, and the share of free flight.
struct Following {
  Float average[3], lambda;
};

// `deep`: nothing flies freely, by the continuous rule. `fixed`: null by the rule as printed, which knows no own
// particles.
SANDGLASS_INLINE Following find_following(const RefineArgs* a, const Fixed* fixed, const Flow& flow, const Own& own,
                                          bool deep, Grains* g) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  const Float inverse = one / select(flow.weight <= zero, one, flow.weight);
  Following f = {{flow.x * inverse, flow.y * inverse, flow.z * inverse}, zero};
  if (!deep) {
    f.lambda = free_flight(a, flow);
    if (fixed != nullptr && a->own_particles != 0 && any(own.known))
      stay_with_own(fixed->own, own, flow.weight, g->number, f.average, g->velocity);
  }
  if (any(g->settled)) {
    g->settled = g->settled & (f.average[0] == zero) & (f.average[1] == zero) & (f.average[2] == zero);
    for (int k = 0; k < 3; ++k) g->position[k] = select(g->settled, g->position[k], g->position[k] + flow.push[k]);
  } else {
    for (int k = 0; k < 3; ++k) g->position[k] = g->position[k] + flow.push[k];
  }
  return f;
}

SANDGLASS_INLINE void take_step(const RefineArgs* a, const Following& f, Grains* g) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), step = broadcast(a->step);
  for (int k = 0; k < 3; ++k) {
    const Float fall = g->velocity[k] + step * broadcast(a->gravity[k]);
    g->velocity[k] = select(g->settled, zero, (one - f.lambda) * f.average[k] + f.lambda * fall);
    g->position[k] = g->position[k] + step * g->velocity[k];
  }
}

// Step by step, because they are fast enough to pass through something thin.
SANDGLASS_NOINLINE void follow_in_steps(const RefineArgs* a, const Following& f, Mask lanes, Grains* g) {
  Grains one_by_one = *g;
  for (uint32_t s = 0; s < a->steps; ++s) {
    take_step(a, f, &one_by_one);
    const ColliderFrame* const after =
        a->step_colliders != nullptr ? a->step_colliders + s * a->collider_count : a->colliders;
    if (s + 1 != a->steps) keep_outside(a, after, lanes, one_by_one.position, one_by_one.velocity);
  }
  for (int k = 0; k < 3; ++k) {
    g->position[k] = select(lanes, one_by_one.position[k], g->position[k]);
    g->velocity[k] = select(lanes, one_by_one.velocity[k], g->velocity[k]);
  }
}

// All steps at once: after s of them the velocity is (1 - lambda^s) average + lambda^s v + (lambda + .. + lambda^s)
// step gravity.
SANDGLASS_INLINE void follow_at_once(const RefineArgs* a, const Fixed& fixed, const Following& f, bool deep, Mask lanes,
                                     Grains* g) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), step = fixed.step, steps = fixed.steps;
  Float velocity[3], moved[3];  // moved: the sum of the velocities of all steps; then the position
  for (int k = 0; k < 3; ++k) {
    velocity[k] = f.average[k];
    moved[k] = steps * f.average[k];
  }
  if (!deep) {
    const Mask free = zero < f.lambda;
    Float power = one, sum = zero, sums = zero;
    for (uint32_t s = 0; s < a->steps; ++s) {
      power = power * f.lambda;
      sum = sum + power;
      sums = sums + sum;
    }
    for (int k = 0; k < 3; ++k) {
      const Float fall = broadcast(a->step * a->gravity[k]), before = g->velocity[k];
      velocity[k] = select(free, (one - power) * f.average[k] + power * before + sum * fall, velocity[k]);
      moved[k] = select(free, (steps - sum) * f.average[k] + sum * before + sums * fall, moved[k]);
    }
  }
  const Mask stays = g->settled | and_not(g->inside, lanes);
  if (any(stays)) {
    for (int k = 0; k < 3; ++k) {
      velocity[k] = select(stays, select(g->settled, zero, g->velocity[k]), velocity[k]);
      moved[k] = select(stays, g->position[k], g->position[k] + step * moved[k]);
    }
  } else {
    for (int k = 0; k < 3; ++k) moved[k] = g->position[k] + step * moved[k];
  }
  for (int k = 0; k < 3; ++k) {
    g->velocity[k] = velocity[k];
    g->position[k] = moved[k];
  }
}

// Whether a lane may be in a collider.
SANDGLASS_INLINE bool reaches_collider(const RefineArgs* a, const Float position[3]) {
  const Float radius = broadcast(a->grain_radius);
  for (uint32_t c = 0; c < a->collider_count; ++c) {
    const ColliderFrame& collider = a->colliders[c];
    if (collider.shape != SANDGLASS_SHAPE_HALF_SPACE) {
      if (!far_from(collider, position, a->grain_radius)) return true;
      continue;
    }
    const Surface surface = collider_surface(collider, position[0], position[1], position[2]);
    if (any(broadcast(0.0f) < radius - surface.distance)) return true;
  }
  return false;
}

SANDGLASS_NOINLINE void leave_colliders(const RefineArgs* a, Grains* g) {
  const Mask again = keep_outside(a, a->colliders, g->inside, g->position, g->velocity);
  if (any(again)) keep_outside(a, a->colliders, again, g->position, g->velocity);
}

// With a grid: one look-up for all steps. What is rare works on a copy, so that the grains can stay in registers.
SANDGLASS_INLINE void follow(const RefineArgs* a, const Fixed& fixed, LastBlock* last, Grains* g) {
  const Float zero = broadcast(0.0f);
  Flow flow = no_flow();
  Own own = nobodys_own();
  Mask left = sound_places(g->inside, g->position);
  bool deep = false;
  if (any(left)) {
    deep = read_flow(a, fixed, &left, g->position, last, &flow, &own);
    if (!deep && any(left)) {  // the grid has no room there
      Flow gathered = {flow.weight, flow.x, flow.y, flow.z, flow.largest, flow.free, {zero, zero, zero}};
      const Float position[3] = {g->position[0], g->position[1], g->position[2]};
      gather_all(a, left, position, &gathered);
      flow.weight = gathered.weight;
      flow.x = gathered.x;
      flow.y = gathered.y;
      flow.z = gathered.z;
      flow.largest = gathered.largest;
      flow.free = gathered.free;
    }
  }
  const Following f = find_following(a, &fixed, flow, own, deep, g);
  const Float before =
      g->velocity[0] * g->velocity[0] + g->velocity[1] * g->velocity[1] + g->velocity[2] * g->velocity[2];
  const Float now = f.average[0] * f.average[0] + f.average[1] * f.average[1] + f.average[2] * f.average[2];
  const Mask swift = and_not(g->inside & (fixed.fast < maximum(before, now)), g->settled);
  if (any(swift)) {
    const Following those = {{f.average[0], f.average[1], f.average[2]}, f.lambda};
    Grains stepping = copy_of(*g);
    follow_in_steps(a, those, swift, &stepping);
    for (int k = 0; k < 3; ++k) {
      g->position[k] = stepping.position[k];
      g->velocity[k] = stepping.velocity[k];
    }
  }
  follow_at_once(a, fixed, f, deep, and_not(g->inside, swift), g);
  if (reaches_collider(a, g->position)) {
    Grains leaving = copy_of(*g);
    leave_colliders(a, &leaving);
    for (int k = 0; k < 3; ++k) {
      g->position[k] = leaving.position[k];
      g->velocity[k] = leaving.velocity[k];
    }
  }
}

// Without one: a look-up for each step.
SANDGLASS_NOINLINE void follow_particles(const RefineArgs* a, Grains* g) {
  for (uint32_t s = 0; s < a->steps; ++s) {
    Flow flow = no_flow();
    gather_all(a, sound_places(g->inside, g->position), g->position, &flow);
    take_step(a, find_following(a, nullptr, flow, nobodys_own(), false, g), g);
    keep_outside(a, a->colliders, g->inside, g->position, g->velocity);
  }
}

// Where grains were, if they are no longer in the world.
SANDGLASS_INLINE uint32_t put_back(const Float before[k_record_floats], Grains* g) {
  const Float limit = broadcast(k_coordinate_bound), speed_limit = broadcast(1e6f);
  const Mask sound = within(g->position[0], limit) & within(g->position[1], limit) & within(g->position[2], limit) &
                     within(g->velocity[0], speed_limit) & within(g->velocity[1], speed_limit) &
                     within(g->velocity[2], speed_limit);
  const Mask bad = and_not(g->inside, sound);
  if (!any(bad)) return 0;
  // Velocity 0. A coordinate that was no better becomes 0.
  for (int k = 0; k < 3; ++k) {
    const Mask number = within(before[k], limit);
    g->position[k] = select(bad, keep(number, before[k]), g->position[k]);
    g->velocity[k] = keep(and_not(g->inside, bad), g->velocity[k]);
  }
  return count(bad);
}

template <bool k_by_grid>
SANDGLASS_INLINE void refine_by(const RefineArgs* a, uint32_t begin, uint32_t end, RefineExtent* extent) {
  const Float one = broadcast(1.0f), zero = broadcast(0.0f);
  const Fixed fixed = fixed_of(a);
  uint32_t quarantined = 0, changed = 0;
  LastBlock last = no_block_yet();
  for (uint32_t item = begin; item < end; item += k_lane_group) {
    const uint32_t group_number = a->groups[item / k_lane_group], first_grain = group_number * k_lane_group;
    const uint32_t last_grain = first_grain + (end - item < k_lane_group ? end - item : k_lane_group);
    Mask keeps_still = one == one;
    bool changes = false;
    for (uint32_t i = first_grain; i < last_grain; i += k_width) {
      float* record = floats_of(a->grains + i);
      Float grain[k_record_floats];
      load_records(record, grain);
      Grains g;
      for (int k = 0; k < 3; ++k) {
        g.position[k] = grain[k];
        g.velocity[k] = grain[k_vx + k];
      }
      g.inside = lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->grain_count));
      g.settled = fixed.still_sweeps <= grain[k_still_sweeps];
      g.number = grain[k_number];
      if (k_by_grid) follow(a, fixed, &last, &g);
      else follow_particles(a, &g);
      quarantined += put_back(grain, &g);
      const Mask still = (absolute(g.position[0] - grain[k_x]) <= fixed.still_distance) &
                         (absolute(g.position[1] - grain[k_y]) <= fixed.still_distance) &
                         (absolute(g.position[2] - grain[k_z]) <= fixed.still_distance);
      const Float sweeps = keep(still, minimum(grain[k_still_sweeps] + one, fixed.still_sweeps));
      const Mask rests = (g.velocity[0] == zero) & (g.velocity[1] == zero) & (g.velocity[2] == zero);
      keeps_still = and_not(keeps_still, and_not(g.inside, (fixed.still_sweeps <= sweeps) & rests));
      Float moved[k_record_floats];
      for (int k = 0; k < 3; ++k) {
        moved[k] = g.position[k];
        moved[k_vx + k] = g.velocity[k];
      }
      changes = changes || any(and_not(g.inside, still));
      if (!changes) {
        Mask same = one == one;
        for (int k = 0; k < 3; ++k) same = same & (moved[k] == grain[k]) & (moved[k_vx + k] == grain[k_vx + k]);
        changes = any(and_not(g.inside, same));
      }
      moved[k_number] = grain[k_number];
      moved[k_still_sweeps] = sweeps;
      if (i + k_width > a->grain_count)
        for (uint32_t c = 0; c < k_record_floats; ++c) moved[c] = select(g.inside, moved[c], grain[c]);
      store_records(record, moved);
    }
    a->still[group_number] = all(keeps_still) ? 1 : 0;
    if (changes) {
      a->stamps[group_number] = a->stamp;
      ++changed;
    }
  }
  extent->quarantined = quarantined;
  extent->changed = changed;
}

static void refine_grains(const RefineArgs* a, uint32_t begin, uint32_t end, RefineExtent* extent) {
  if (a->motion != nullptr) refine_by<true>(a, begin, end, extent);
  else refine_by<false>(a, begin, end, extent);
}
