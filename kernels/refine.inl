// Grains are advected by the velocity field of the particles, (4.39)-(4.44) of the dissertation, blended into free
// flight near and outside the surface, and kept outside the colliders. Lane = grain. Grains are sorted by cell, so
// k_width neighbouring lanes share almost all candidates. The candidates are found once for such a group of lanes, by
// their distance to the group's bounding box, and each is then broadcast to all lanes.
//
// A candidate out of the box's reach has weight exactly 0 in every lane: the box's distance is computed with the same
// operations, which round monotonically, and the weight is max(0, (h^2 - d^2)/h^2)^3. So neither the lane count nor the
// grouping changes a sum.

constexpr uint32_t k_candidates_max = 512;  // gathered before they are added up: 2 KB of stack

struct Flow {
  Float weight, x, y, z, largest;
  Float free;     // the sum of W times the share of free fall
  Float push[3];  // metres
};

SANDGLASS_INLINE Flow no_flow() {
  const Float zero = broadcast(0.0f);
  return {zero, zero, zero, zero, zero, zero, {zero, zero, zero}};
}

SANDGLASS_INLINE void accumulate_flow(const RefineArgs* a, const uint32_t* index, uint32_t n, Float x, Float y, Float z,
                                      Flow* flow) {
  const Float h2 = broadcast(a->support * a->support), inverse = broadcast(1.0f / (a->support * a->support));
  const Float zero = broadcast(0.0f);
  for (uint32_t c = 0; c < n; ++c) {
    Float p[k_record_floats];
    broadcast_record(floats_of(a->snapshot + index[c]), p);
    const Float dx = p[k_x] - x, dy = p[k_y] - y, dz = p[k_z] - z;
    const Float d2 = dx * dx + dy * dy + dz * dz;
    const Float t = maximum((h2 - d2) * inverse, zero);
    const Float weight = t * t * t;
    flow->weight = flow->weight + weight;
    flow->x = flow->x + weight * p[k_vx];
    flow->y = flow->y + weight * p[k_vy];
    flow->z = flow->z + weight * p[k_vz];
    flow->largest = maximum(weight, flow->largest);
    flow->free = flow->free + weight * p[k_free_fall];
  }
}

// Sums over the particles near the lanes that `lanes` holds, whose bounding box is at most two cells wide.
SANDGLASS_INLINE void gather_flow(const RefineArgs* a, Mask lanes, const Float position[3], Flow* flow) {
  const Float x = position[0], y = position[1], z = position[2];
  const Float big = broadcast(3e38f), small = broadcast(-3e38f);
  const float low[3] = {lane_minimum(select(lanes, x, big)), lane_minimum(select(lanes, y, big)),
                        lane_minimum(select(lanes, z, big))};
  const float high[3] = {lane_maximum(select(lanes, x, small)), lane_maximum(select(lanes, y, small)),
                         lane_maximum(select(lanes, z, small))};
  int32_t first[3], last[3];
  uint32_t mask[3];
  for (int k = 0; k < 3; ++k) {
    // A reach a little longer than h: whatever its squared distance rounds to, no candidate below h^2 is in a cell that
    // is left out. Differences and products round monotonically.
    first[k] = floor_whole((low[k] - a->support * 1.0001f) * a->grid.inverse_cell);
    last[k] = floor_whole((high[k] + a->support * 1.0001f) * a->grid.inverse_cell);
    mask[k] = (1u << a->grid.bits[k]) - 1;
  }
  const Float h2 = broadcast(a->support * a->support), zero = broadcast(0.0f);
  alignas(64) uint32_t index[k_candidates_max + 2 * k_lane_group];
  uint32_t n = 0;
  Flow sum = no_flow();
  for (int32_t cz = first[2]; cz <= last[2]; ++cz) {
    for (int32_t cy = first[1]; cy <= last[1]; ++cy) {
      const uint32_t row =
          (((static_cast<uint32_t>(cz) & mask[2]) << a->grid.bits[1]) | (static_cast<uint32_t>(cy) & mask[1]))
          << a->grid.bits[0];
      int32_t cx = first[0];
      while (cx <= last[0]) {
        // As many cells as lie side by side in storage.
        const uint32_t stored = static_cast<uint32_t>(cx) & mask[0];
        const uint32_t until_wrap = mask[0] + 1 - stored;
        const uint32_t wanted = static_cast<uint32_t>(last[0] - cx + 1);
        const uint32_t cells = wanted < until_wrap ? wanted : until_wrap;
        const uint32_t begin = a->grid.starts[row + stored], end = a->grid.starts[row + stored + cells];
        for (uint32_t c = begin; c < end; c += k_width) {
          const Float px = load(a->positions[0] + c), py = load(a->positions[1] + c), pz = load(a->positions[2] + c);
          const Float dx = maximum(maximum(broadcast(low[0]) - px, px - broadcast(high[0])), zero);
          const Float dy = maximum(maximum(broadcast(low[1]) - py, py - broadcast(high[1])), zero);
          const Float dz = maximum(maximum(broadcast(low[2]) - pz, pz - broadcast(high[2])), zero);
          const Int lane = lane_index() + broadcast(static_cast<int32_t>(c));
          const Mask near = (dx * dx + dy * dy + dz * dz < h2) & (lane < broadcast(static_cast<int32_t>(end)));
          n += compress_store(index + n, lane, near);
          if (n >= k_candidates_max) {
            accumulate_flow(a, index, n, x, y, z, &sum);
            n = 0;
          }
        }
        cx += static_cast<int32_t>(cells);
      }
    }
  }
  accumulate_flow(a, index, n, x, y, z, &sum);
  flow->weight = select(lanes, sum.weight, flow->weight);
  flow->x = select(lanes, sum.x, flow->x);
  flow->y = select(lanes, sum.y, flow->y);
  flow->z = select(lanes, sum.z, flow->z);
  flow->largest = select(lanes, sum.largest, flow->largest);
  flow->free = select(lanes, sum.free, flow->free);
}

// Arguments in every lane: made once, because compilers do not know that what is stored is none of them.
struct Fixed {
  GridPlace grid;
  OwnUnits own;
  Float push, push_max, step, steps, still_distance, still_sweeps;
  Float fast;  // metres a second, squared, from which a grain takes its steps one by one
  bool pushes;
};

SANDGLASS_INLINE Fixed fixed_of(const RefineArgs* a) {
  Fixed f = {};
  if (a->motion != nullptr) {
    f.grid = place_of(a->motion);
    f.own = own_units_of(a);
  }
  f.push = broadcast(a->push);
  f.push_max = broadcast(a->push_max);
  f.pushes = a->push != 0.0f;
  f.step = broadcast(a->step);
  f.steps = broadcast(static_cast<float>(a->steps));
  f.still_distance = broadcast(a->still_distance);
  f.still_sweeps = broadcast(a->still_sweeps);
  // Half a particle radius in a step, less what gravity adds.
  const float length = a->support * (1.0f / 6.0f) / a->step - a->fall;
  f.fast = broadcast(length > 0.0f ? length * length : 0.0f);
  return f;
}

// How far a grain is pushed down the gradient of the grains' density, which is read between the centres of cells.
SANDGLASS_INLINE void read_push(const Fixed& fixed, const uint8_t* const* density, const Float inside[3], Flow* flow) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  Float share[3], away[3];
  Int first = broadcast(0);
  for (int k = 2; k >= 0; --k) {
    const Float scaled = inside[k] * broadcast(3.0f) + broadcast(1.5f);  // 1 is the centre of the first cell
    const Int cell = minimum(to_int(scaled), broadcast(static_cast<int32_t>(k_block_cells + 1)));
    share[k] = scaled - to_float(cell);
    away[k] = one - share[k];
    first = shift_left(first, 4) - shift_left(first, 1) + cell;
  }
  constexpr int32_t k_row = k_density_cells, k_plane = k_row * k_row;
  alignas(64) uint32_t at[k_lane_group];
  store(at, first);
  const uint8_t* squares[k_width];
  for (uint32_t l = 0; l < k_width; ++l) squares[l] = density[l] + at[l];
  Float edge[4], slope_x[4];
  const Int byte = broadcast(255);
  for (int32_t z = 0; z < 2; ++z) {
    const Int square = load_byte_squares<k_density_cells>(squares, z * k_plane - (k_plane + k_row + 1));
    const Float corner[4] = {to_float(square & byte), to_float(shift_right(square, 8) & byte),
                             to_float(shift_right(square, 16) & byte), to_float(shift_right(square, 24))};
    for (int32_t y = 0; y < 2; ++y) {
      slope_x[2 * z + y] = corner[2 * y + 1] - corner[2 * y];
      edge[2 * z + y] = corner[2 * y] + share[0] * slope_x[2 * z + y];
    }
  }
  const Float slope_y[2] = {edge[1] - edge[0], edge[3] - edge[2]};
  const Float low = edge[0] + share[1] * slope_y[0], high = edge[2] + share[1] * slope_y[1];
  const Float slope_z = high - low, value = low + share[2] * slope_z;
  const Float slope[3] = {away[2] * (away[1] * slope_x[0] + share[1] * slope_x[1]) +
                              share[2] * (away[1] * slope_x[2] + share[1] * slope_x[3]),
                          away[2] * slope_y[0] + share[2] * slope_y[1], slope_z};
  const Float scale = fixed.push / at_least(value, one);
  const Float length2 = scale * scale * (slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]);
  const Float shorter = at_most(fixed.push_max / square_root(at_least(length2, broadcast(1e-30f))), one) * scale;
  for (int k = 0; k < 3; ++k) flow->push[k] = zero - shorter * slope[k];
}

// The nodes at the corners of a grain's cell: records behind the first of them, times the floats of a record.
constexpr uint32_t k_corners[8] = {0, 8, 40, 48, 200, 208, 240, 248};

// How much a place counts for each of the corners.
SANDGLASS_INLINE void corner_shares(const Float local[3], Float share[8]) {
  const Float one = broadcast(1.0f);
  const Float to_low[3] = {one - local[0], one - local[1], one - local[2]};
  const Float rows[4] = {to_low[2] * to_low[1], to_low[2] * local[1], local[2] * to_low[1], local[2] * local[1]};
  for (int row = 0; row < 4; ++row) {
    share[2 * row] = rows[row] * to_low[0];
    share[2 * row + 1] = rows[row] * local[0];
  }
}

// What the corners' other halves say.
struct Nearest {
  Float squared;  // distance
  Float number;   // in the snapshot
};

// The nearest of the particles that are nearest to the corners, if it is within h. Of these one is the nearest to the
// grain, but for rare ties.
SANDGLASS_INLINE Nearest read_nearest(const float* const* records, const Float position[3], Float h2) {
  Nearest nearest = {h2, broadcast(0.0f)};
  for (int corner = 0; corner < 8; ++corner) {
    Float node[4];
    load_quads(records, k_corners[corner] + k_node_nearest, node);
    const Float dx = node[0] - position[0], dy = node[1] - position[1], dz = node[2] - position[2];
    const Float squared = dx * dx + dy * dy + dz * dz;
    nearest.number = select(squared < nearest.squared, node[3], nearest.number);
    nearest.squared = minimum(squared, nearest.squared);
  }
  return nearest;
}

// Where lanes read. Lanes that are in no block read anything.
struct Places {
  const float* records[k_width];
  const uint8_t* density[k_width];
  Mask known;    // lanes that are in a block
  Mask lacking;  // lanes that the grid has no room for
};

// The grid had no room for some block, so the records of those beside it do not tell all.
SANDGLASS_APART void find_lacking(const MotionGrid* grid, Mask lanes, const uint32_t* numbers, Places* places) {
  alignas(64) uint32_t lacks[k_lane_group];
  for (uint32_t l = 0; l < k_width; ++l) {
    const uint32_t number = numbers[l];
    lacks[l] = number == k_no_block || (grid->blocks[number].state & k_block_incomplete) != 0 ? 1 : 0;
  }
  places->lacking = lanes & (broadcast(0) < load(lacks));
  places->known = and_not(places->known, places->lacking);
}

SANDGLASS_INLINE void find_places(const MotionGrid* grid, Mask lanes, const BlockPlace& place, Int corner,
                                  LastBlock* last, Places* places) {
  const Int none = broadcast(static_cast<int32_t>(k_no_block));
  alignas(64) uint32_t numbers[k_lane_group], records[k_lane_group];
  const bool one = find_blocks(grid, lanes, place, last, numbers);
  places->known = lanes;
  places->lacking = and_not(lanes, lanes);
  if (one && last->number != k_no_block && grid->overflowed == 0) {
    const uint8_t* density = density_of(*grid, last->number);
    // Lanes that are not asked for have coordinates of 0 and so a corner of the block too.
    store(records, corner + broadcast(static_cast<int32_t>(last->number * k_block_records)));
    for (uint32_t l = 0; l < k_width; ++l) {
      places->records[l] = grid->nodes + uint64_t{records[l]} * k_record_floats;
      places->density[l] = density;
    }
    return;
  }
  if (one) store(numbers, broadcast(static_cast<int32_t>(last->number)));
  const Mask nowhere = load(numbers) == none;
  places->known = and_not(lanes, nowhere);
  if (grid->overflowed != 0) find_lacking(grid, lanes, numbers, places);
  if (any(nowhere)) store(numbers, select(nowhere, broadcast(0), load(numbers)));
  static_assert(k_block_records == 1u << 7);
  store(records, shift_left(load(numbers), 7) + corner);
  for (uint32_t l = 0; l < k_width; ++l) {
    places->records[l] = grid->nodes + uint64_t{records[l]} * k_record_floats;
    places->density[l] = density_of(*grid, numbers[l]);
  }
}

// The share of the push that a grain takes: all inside the pile, near a particle, and around a lone particle, as far
// as its weight reaches. It fades where each of these ends, so that no grain is pushed by a jump.
SANDGLASS_INLINE Float push_share(const RefineArgs* a, const Flow& sum, Float nearest, Float lone) {
  const Float one = broadcast(1.0f);
  const Float within = one - fade(sum.weight, 0.8f * k_weight_inside, k_weight_inside);
  const Float near = fade(nearest * broadcast(1.0f / (a->push_reach * a->push_reach)), 0.7f, 1.3f);
  return maximum(maximum(within, near), lone * (one - fade(sum.weight, 0.0f, 0.02f)));
}

// The sums at the lanes that `lanes` holds, between the nodes of the grid. Leaves in `lanes` those that the grid has no
// room for. True: all lanes are inside the pile, where nothing flies freely.
SANDGLASS_INLINE bool read_flow(const RefineArgs* a, const Fixed& fixed, Mask* lanes, const Float at_lanes[3],
                                LastBlock* last, Flow* flow, Own* own) {
  const MotionGrid* grid = a->motion;
  const Float zero = broadcast(0.0f);
  const BlockPlace place = place_in_block(fixed.grid, *lanes, at_lanes);
  Float local[3], corner_share[8], sums[4];
  Int corner = broadcast(0);
  for (int k = 2; k >= 0; --k) {
    const Int cell = minimum(to_int(place.inside[k]), broadcast(3));
    local[k] = place.inside[k] - to_float(cell);
    // Records of a block: x fastest, 5 along an axis.
    corner = shift_left(corner, 2) + corner + cell;
  }
  Places places;
  find_places(grid, *lanes, place, corner, last, &places);
  const Mask known = places.known;
  *lanes = places.lacking;
  if (!any(known)) return false;
  corner_shares(local, corner_share);
  blend_quads(places.records, k_corners, corner_share, sums);
  Flow sum = {sums[0], sums[1], sums[2], sums[3], zero, zero, {zero, zero, zero}};
  // In the pile's inside nothing flies freely, so the nearest particle does not matter.
  const Mask inside = known & (broadcast(k_weight_inside) <= sum.weight);
  if (all(inside)) {
    if (fixed.pushes) read_push(fixed, places.density, place.inside, &sum);
    flow->weight = sum.weight;
    flow->x = sum.x;
    flow->y = sum.y;
    flow->z = sum.z;
    for (int k = 0; k < 3; ++k) flow->push[k] = sum.push[k];
    return true;
  }
  const Float one = broadcast(1.0f);
  Float share = one;  // of the push
  if (any(and_not(known, inside))) {
    Float position[3];
    for (int k = 0; k < 3; ++k) position[k] = at_lanes[k] - fixed.grid.origin[k];
    const Float h2 = broadcast(grid->support * grid->support);
    const Nearest nearest = read_nearest(places.records, position, h2);
    read_own(a, fixed.own, and_not(known, inside) & (nearest.squared < h2), nearest.number, at_lanes, own);
    const Float t = at_least((h2 - nearest.squared) * broadcast(1.0f / (grid->support * grid->support)), zero);
    sum.largest = select(inside, zero, t * t * t);
    sum.weight = maximum(sum.weight, sum.largest);
    sum.free = own->free * sum.weight;
    own->lone = one - fade(sum.largest / select(sum.weight <= zero, one, sum.weight), 0.6f, 0.8f);
    if (fixed.pushes) share = push_share(a, sum, nearest.squared, own->lone);
  }
  flow->weight = keep(known, sum.weight);
  flow->x = keep(known, sum.x);
  flow->y = keep(known, sum.y);
  flow->z = keep(known, sum.z);
  flow->largest = keep(known, sum.largest);
  flow->free = keep(known, sum.free);
  const Mask pushed = known & (zero < share);
  if (fixed.pushes && any(pushed)) {
    read_push(fixed, places.density, place.inside, &sum);
    for (int k = 0; k < 3; ++k) flow->push[k] = keep(pushed, share * sum.push[k]);
  }
  return false;
}

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

// Returns the lanes that a field moved: its distance is rough, in corners and far inside.
SANDGLASS_APART Mask keep_outside(const RefineArgs* a, const ColliderFrame* colliders, Mask lanes, Float position[3],
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
    if (collider.shape == SANDGLASS_SHAPE_FIELD) rough = rough | hit;
    const Float n[3] = {surface.nx, surface.ny, surface.nz};
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

// The sums at the lanes that `lanes` holds, from the particles. Lanes that are far apart are gathered separately.
SANDGLASS_APART void gather_all(const RefineArgs* a, Mask lanes, const Float position[3], Flow* flow) {
  const Float wide = broadcast(1.0f / a->grid.inverse_cell);
  alignas(64) float at[3][k_lane_group];
  for (int k = 0; k < 3; ++k) store(at[k], position[k]);
  for (Mask left = lanes; any(left);) {
    const uint32_t l = first(left);
    const Mask group = left & (absolute(position[0] - broadcast(at[0][l])) <= wide) &
                       (absolute(position[1] - broadcast(at[1][l])) <= wide) &
                       (absolute(position[2] - broadcast(at[2][l])) <= wide);
    gather_flow(a, group, position, flow);
    left = and_not(left, group);
  }
}

SANDGLASS_INLINE Mask sound_places(Mask lanes, const Float position[3]) {
  const Float limit = broadcast(k_coordinate_bound);
  return lanes & within(position[0], limit) & within(position[1], limit) & within(position[2], limit);
}

// As many grains as there are lanes, on their way through a sweep.
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
SANDGLASS_APART void follow_in_steps(const RefineArgs* a, const Following& f, Mask lanes, Grains* g) {
  Grains one_by_one = *g;
  for (uint32_t s = 0; s < a->steps; ++s) {
    take_step(a, f, &one_by_one);
    const ColliderFrame* const after =
        a->on_their_way != nullptr ? a->on_their_way + s * a->collider_count : a->colliders;
    if (s + 1 != a->steps) keep_outside(a, after, lanes, one_by_one.position, one_by_one.velocity);
  }
  for (int k = 0; k < 3; ++k) {
    g->position[k] = select(lanes, one_by_one.position[k], g->position[k]);
    g->velocity[k] = select(lanes, one_by_one.velocity[k], g->velocity[k]);
  }
}

// All steps at once: after s of them the velocity is (1 - lambda^s) average + lambda^s v + (lambda + .. + lambda^s) step
// gravity.
SANDGLASS_INLINE void follow_at_once(const RefineArgs* a, const Fixed& fixed, const Following& f, bool deep, Mask lanes,
                                     Grains* g) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), step = fixed.step, steps = fixed.steps;
  Float velocity[3], way[3];
  for (int k = 0; k < 3; ++k) {
    velocity[k] = f.average[k];
    way[k] = steps * f.average[k];
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
      way[k] = select(free, (steps - sum) * f.average[k] + sum * before + sums * fall, way[k]);
    }
  }
  const Mask stays = g->settled | and_not(g->inside, lanes);
  if (any(stays)) {
    for (int k = 0; k < 3; ++k) {
      velocity[k] = select(stays, select(g->settled, zero, g->velocity[k]), velocity[k]);
      way[k] = select(stays, g->position[k], g->position[k] + step * way[k]);
    }
  } else {
    for (int k = 0; k < 3; ++k) way[k] = g->position[k] + step * way[k];
  }
  for (int k = 0; k < 3; ++k) {
    g->velocity[k] = velocity[k];
    g->position[k] = way[k];
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

SANDGLASS_APART void leave_colliders(const RefineArgs* a, Grains* g) {
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
SANDGLASS_APART void follow_particles(const RefineArgs* a, Grains* g) {
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
