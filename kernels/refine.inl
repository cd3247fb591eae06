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
  Float push[3];  // metres
};

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
  }
}

// Sums over the particles near the lanes that `lanes` holds, whose bounding box is at most two cells wide.
SANDGLASS_INLINE void gather_flow(const RefineArgs* a, Mask lanes, Float x, Float y, Float z, Flow* flow) {
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
    first[k] = floor_scalar((low[k] - a->support * 1.0001f) * a->grid.inverse_cell);
    last[k] = floor_scalar((high[k] + a->support * 1.0001f) * a->grid.inverse_cell);
    mask[k] = (1u << a->grid.bits[k]) - 1;
  }
  const Float h2 = broadcast(a->support * a->support), zero = broadcast(0.0f);
  alignas(64) uint32_t index[k_candidates_max + 2 * k_lane_group];
  uint32_t n = 0;
  Flow sum = {zero, zero, zero, zero, zero, {zero, zero, zero}};
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
}

// What a block holds, or null. lacking: the grid has no room there, so the records do not tell all.
struct Block {
  const float* records;
  const uint8_t* density;
  bool lacking;
};

SANDGLASS_INLINE Block look_up(const MotionGrid* grid, const float at[3]) {
  const uint32_t number =
      motion_find(*grid, static_cast<int32_t>(at[0]), static_cast<int32_t>(at[1]), static_cast<int32_t>(at[2]));
  if (number == k_no_block) return {nullptr, nullptr, grid->overflowed != 0};
  return {grid->nodes + static_cast<uint64_t>(number) * k_block_records * k_record_floats, density_of(*grid, number),
          (grid->blocks[number].state & k_block_incomplete) != 0};
}

// How far a grain is pushed down the gradient of the grains' density, which is read between the centres of cells.
SANDGLASS_INLINE void read_push(const RefineArgs* a, const uint8_t* const* density, const Float inside[3], Flow* flow) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  Float share[3], away[3];
  Int first = broadcast(0);
  for (int k = 2; k >= 0; --k) {
    const Float scaled = inside[k] * broadcast(3.0f) + broadcast(1.5f);  // 0 is the centre of the first cell
    const Float cell = minimum(to_float(to_int(scaled)), broadcast(static_cast<float>(k_block_cells + 1)));
    share[k] = scaled - cell, away[k] = one - share[k];
    first = shift_left(first, 4) + to_int(cell);
  }
  alignas(64) uint32_t at[k_lane_group], corners[2][k_lane_group];  // four bytes each: x, then y
  store(at, first);
  for (uint32_t l = 0; l < k_width; ++l) {
    const uint8_t* d = density[l] + at[l];
    for (int z = 0; z < 2; ++z, d += k_density_cells * k_density_cells) {
      uint16_t low, high;
      __builtin_memcpy(&low, d, 2);
      __builtin_memcpy(&high, d + k_density_cells, 2);
      corners[z][l] = low | static_cast<uint32_t>(high) << 16;
    }
  }
  Float edge[4], slope_x[4];
  const Int byte = broadcast(255);
  for (int k = 0; k < 4; ++k) {
    const Int pair = k % 2 == 0 ? load(corners[k / 2]) : shift_right(load(corners[k / 2]), 16);
    const Float low = to_float(pair & byte), high = to_float(shift_right(pair, 8) & byte);
    slope_x[k] = high - low;
    edge[k] = low + share[0] * slope_x[k];
  }
  const Float low = edge[0] + share[1] * (edge[1] - edge[0]), high = edge[2] + share[1] * (edge[3] - edge[2]);
  const Float value = low + share[2] * (high - low);
  const Float slope[3] = {away[2] * (away[1] * slope_x[0] + share[1] * slope_x[1]) +
                              share[2] * (away[1] * slope_x[2] + share[1] * slope_x[3]),
                          away[2] * (edge[1] - edge[0]) + share[2] * (edge[3] - edge[2]), high - low};
  const Float scale = broadcast(a->push) / maximum(value, one);
  const Float length2 = scale * scale * (slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2]);
  const Float shorter = minimum(broadcast(a->push_max) / square_root(maximum(length2, broadcast(1e-30f))), one) * scale;
  for (int k = 0; k < 3; ++k) flow->push[k] = zero - shorter * slope[k];
}

// Adds the share of the node that is so many records behind the lanes' own.
template <uint32_t k_behind>
SANDGLASS_INLINE void add_corner(const float* const* records, Float share, const Float position[3], Flow* sum,
                                 Float* nearest) {
  Float node[k_record_floats];
  load_records(records, k_behind * k_record_floats, node);
  sum->weight = sum->weight + share * node[k_mobility];
  sum->x = sum->x + share * node[k_vx];
  sum->y = sum->y + share * node[k_vy];
  sum->z = sum->z + share * node[k_vz];
  const Float dx = node[k_x] - position[0], dy = node[k_y] - position[1], dz = node[k_z] - position[2];
  *nearest = minimum(dx * dx + dy * dy + dz * dz, *nearest);
}

// The sums at the lanes that `lanes` holds, between the nodes of the grid. Returns the lanes that the grid has no room
// for.
SANDGLASS_INLINE Mask read_flow(const RefineArgs* a, Mask lanes, const Float at_lanes[3], Flow* flow) {
  const MotionGrid* grid = a->motion;
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  const BlockPlace place = place_in_block(grid, lanes, at_lanes);
  Float local[3], position[3];
  Int corner = broadcast(0);
  for (int k = 2; k >= 0; --k) {
    const Float cell = minimum(to_float(to_int(place.inside[k])), broadcast(3.0f));
    local[k] = place.inside[k] - cell;
    position[k] = at_lanes[k] - broadcast(grid->origin[k]);
    // Records of a block: x fastest, 5 along an axis.
    corner = shift_left(corner, 2) + corner + to_int(cell);
  }
  alignas(64) float at[3][k_lane_group];
  alignas(64) uint32_t corners[k_lane_group];
  for (int k = 0; k < 3; ++k) store(at[k], place.block[k]);
  store(corners, corner);
  const uint32_t sole = first(lanes);
  const float block_at[3] = {at[0][sole], at[1][sole], at[2][sole]};
  const Mask together = (place.block[0] == broadcast(block_at[0])) & (place.block[1] == broadcast(block_at[1])) &
                        (place.block[2] == broadcast(block_at[2]));
  const float* records[k_width];
  const uint8_t* density[k_width];
  Mask known = lanes, lacking = and_not(lanes, lanes);
  if (!any(and_not(lanes, together))) {  // as a rule
    const Block block = look_up(grid, block_at);
    if (block.lacking) return lanes;
    if (block.records == nullptr) return lacking;
    // Lanes that are not asked for have coordinates of 0 and so a corner of the block too.
    for (uint32_t l = 0; l < k_width; ++l)
      records[l] = block.records + corners[l] * k_record_floats, density[l] = block.density;
  } else {
    alignas(64) float wanted[k_lane_group], found[k_lane_group];
    store(wanted, keep(lanes, one));
    for (uint32_t l = 0; l < k_width; ++l) {
      records[l] = grid->nodes, density[l] = density_of(*grid, 0);
      const float lane_at[3] = {at[0][l], at[1][l], at[2][l]};
      found[l] = 0.0f;
      if (wanted[l] == 0.0f) continue;
      const Block block = look_up(grid, lane_at);
      wanted[l] = block.lacking ? 1.0f : 0.0f;
      if (block.lacking || block.records == nullptr) continue;
      records[l] = block.records + corners[l] * k_record_floats, density[l] = block.density;
      found[l] = 1.0f;
    }
    lacking = lanes & (zero < load(wanted));
    known = lanes & (zero < load(found));
    if (!any(known)) return lacking;
  }
  const Float h2 = broadcast(grid->support * grid->support);
  Float nearest = h2;
  Flow sum = {zero, zero, zero, zero, zero, {zero, zero, zero}};
  const Float to_low[3] = {one - local[0], one - local[1], one - local[2]};
  const Float rows[4] = {to_low[2] * to_low[1], to_low[2] * local[1], local[2] * to_low[1], local[2] * local[1]};
  add_corner<0>(records, rows[0] * to_low[0], position, &sum, &nearest);
  add_corner<1>(records, rows[0] * local[0], position, &sum, &nearest);
  add_corner<5>(records, rows[1] * to_low[0], position, &sum, &nearest);
  add_corner<6>(records, rows[1] * local[0], position, &sum, &nearest);
  add_corner<25>(records, rows[2] * to_low[0], position, &sum, &nearest);
  add_corner<26>(records, rows[2] * local[0], position, &sum, &nearest);
  add_corner<30>(records, rows[3] * to_low[0], position, &sum, &nearest);
  add_corner<31>(records, rows[3] * local[0], position, &sum, &nearest);
  // Of the particles that are nearest to the corners one is the nearest to the grain, but for rare ties.
  const Float t = maximum((h2 - nearest) * broadcast(1.0f / (grid->support * grid->support)), zero);
  sum.largest = t * t * t;
  sum.weight = maximum(sum.weight, sum.largest);
  flow->weight = select(known, sum.weight, flow->weight);
  flow->x = select(known, sum.x, flow->x);
  flow->y = select(known, sum.y, flow->y);
  flow->z = select(known, sum.z, flow->z);
  flow->largest = select(known, sum.largest, flow->largest);
  // Around a lone particle they spread without limit.
  const Mask lone = broadcast(0.7f) * sum.weight <= sum.largest;
  const Mask pushed = known & ((nearest < broadcast(a->push_reach * a->push_reach)) | lone);
  if (any(pushed)) {
    read_push(a, density, place.inside, &sum);
    for (int k = 0; k < 3; ++k) flow->push[k] = keep(pushed, sum.push[k]);
  }
  return lacking;
}

// 1 at a and below, 0 at b and above, smooth between.
SANDGLASS_INLINE Float fade(Float value, float a, float b) {
  const Float t =
      minimum(maximum((broadcast(b) - value) * broadcast(1.0f / (b - a)), broadcast(0.0f)), broadcast(1.0f));
  return t * t * (broadcast(3.0f) - broadcast(2.0f) * t);
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
    const Float few =
        fade(flow.largest, a->weight_at_radius - 0.1f, a->weight_at_radius + 0.1f) * fade(flow.weight, 1.2f, 2.0f);
    const Float single = one - fade(ratio, 0.5f, 0.7f);
    lambda = maximum((one - flow.largest) * few, single);
  }
  return select(alone, one, lambda);
}

// Returns the lanes that a field moved: its distance is rough, in corners and far inside.
SANDGLASS_INLINE Mask keep_outside(const RefineArgs* a, Mask lanes, Float position[3], Float velocity[3]) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f);
  Mask rough = and_not(lanes, lanes);
  for (uint32_t c = 0; c < a->collider_count; ++c) {
    const ColliderFrame& collider = a->colliders[c];
    const Surface surface = collider_surface(collider, position[0], position[1], position[2]);
    const Float depth = broadcast(a->grain_radius) - surface.distance;
    const Mask hit = lanes & (zero < depth);
    if (!any(hit)) continue;
    if (collider.shape == SANDGLASS_SHAPE_FIELD) rough = rough | hit;
    const Float n[3] = {surface.nx, surface.ny, surface.nz};
    Float v[3], relative[3], along = zero;
    collider_velocity(collider, position[0], position[1], position[2], v);
    for (int k = 0; k < 3; ++k) {
      position[k] = select(hit, position[k] + depth * n[k], position[k]);
      relative[k] = velocity[k] - v[k];
      along = along + relative[k] * n[k];
    }
    // The inward part of the relative velocity is removed. Coulomb friction reduces the rest.
    const Mask inward = hit & (along < zero);
    Float tangential[3], t2 = zero;
    for (int k = 0; k < 3; ++k) tangential[k] = relative[k] - along * n[k], t2 = t2 + tangential[k] * tangential[k];
    const Float speed = square_root(t2);
    const Float left =
        maximum(one - (broadcast(a->friction) * absolute(along)) / maximum(speed, broadcast(1e-12f)), zero);
    for (int k = 0; k < 3; ++k) velocity[k] = select(inward, v[k] + left * tangential[k], velocity[k]);
  }
  return rough;
}

// The sums at the lanes that `lanes` holds: from the grid where there is one and it has room, else from the particles.
SANDGLASS_INLINE Flow find_flow(const RefineArgs* a, Mask lanes, const Float position[3]) {
  const Float zero = broadcast(0.0f);
  Flow flow = {zero, zero, zero, zero, zero, {zero, zero, zero}};
  const Float limit = broadcast(k_coordinate_bound);
  const Float wide = broadcast(1.0f / a->grid.inverse_cell);  // lanes further apart than this are gathered separately
  Mask left =
      lanes & (absolute(position[0]) < limit) & (absolute(position[1]) < limit) & (absolute(position[2]) < limit);
  if (a->motion != nullptr && any(left)) left = read_flow(a, left, position, &flow);
  while (any(left)) {
    alignas(64) float px[k_lane_group], py[k_lane_group], pz[k_lane_group];
    store(px, position[0]), store(py, position[1]), store(pz, position[2]);
    const uint32_t l = first(left);
    const Mask group = left & (absolute(position[0] - broadcast(px[l])) <= wide) &
                       (absolute(position[1] - broadcast(py[l])) <= wide) &
                       (absolute(position[2] - broadcast(pz[l])) <= wide);
    gather_flow(a, group, position[0], position[1], position[2], &flow);
    left = and_not(left, group);
  }
  return flow;
}

static void refine_grains(const RefineArgs* a, uint32_t begin, uint32_t end, RefineExtent* extent) {
  const Float zero = broadcast(0.0f), one = broadcast(1.0f), limit = broadcast(k_coordinate_bound),
              step = broadcast(a->step);
  const float fast = a->support * (1.0f / 6.0f) / a->step;  // half a particle radius in a step
  uint32_t quarantined = 0;
  for (uint32_t item = begin; item < end; item += k_width) {
    const uint32_t group_number = a->groups[item / k_lane_group];
    const uint32_t i = group_number * k_lane_group + item % k_lane_group;
    float* record = floats_of(a->grains + i);
    Float grain[k_record_floats];
    load_records(record, grain);
    Float position[3] = {grain[k_x], grain[k_y], grain[k_z]};
    Float velocity[3] = {grain[k_vx], grain[k_vy], grain[k_vz]};
    const Mask inside =
        lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->grain_count));
    // A grain that has been still for long enough stays where it is while nothing around it moves.
    Mask settled = broadcast(a->still_sweeps) <= grain[k_still_sweeps];
    Float lambda = zero, average[3] = {zero, zero, zero};
    for (uint32_t s = 0; s < a->steps; ++s) {
      if (s == 0 || a->motion == nullptr) {
        const Flow flow = find_flow(a, inside, position);
        lambda = free_flight(a, flow);
        const Float inverse = one / select(flow.weight <= zero, one, flow.weight);
        average[0] = flow.x * inverse, average[1] = flow.y * inverse, average[2] = flow.z * inverse;
        settled = settled & (average[0] == zero) & (average[1] == zero) & (average[2] == zero);
        for (int k = 0; k < 3; ++k) position[k] = select(settled, position[k], position[k] + flow.push[k]);
      }
      for (int k = 0; k < 3; ++k) {
        const Float fall = velocity[k] + step * broadcast(a->gravity[k]);
        velocity[k] = select(settled, zero, (one - lambda) * average[k] + lambda * fall);
        position[k] = position[k] + step * velocity[k];
      }
      // With a grid, on the way only those that are fast enough to pass through something thin.
      Mask kept = inside;
      const Float speed2 = velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
      if (s + 1 != a->steps && a->motion != nullptr) {
        kept = kept & (broadcast(fast * fast) < speed2);
        if (!any(kept)) continue;
      }
      const Mask again = keep_outside(a, kept, position, velocity);
      if (a->motion != nullptr && s + 1 == a->steps && any(again)) keep_outside(a, again, position, velocity);
    }
    const Mask sound = (absolute(position[0]) < limit) & (absolute(position[1]) < limit) &
                       (absolute(position[2]) < limit) & (absolute(velocity[0]) < broadcast(1e6f)) &
                       (absolute(velocity[1]) < broadcast(1e6f)) & (absolute(velocity[2]) < broadcast(1e6f));
    const Mask bad = and_not(inside, sound);
    if (any(bad)) {
      // Back to where it was, with velocity 0. A coordinate that was no better becomes 0.
      quarantined += count(bad);
      for (int k = 0; k < 3; ++k) {
        const Mask number = absolute(grain[k]) < limit;
        position[k] = select(bad, keep(number, grain[k]), position[k]);
        velocity[k] = select(bad, zero, velocity[k]);
      }
    }
    const Float still_distance = broadcast(a->still_distance);
    const Mask still = (absolute(position[0] - grain[k_x]) <= still_distance) &
                       (absolute(position[1] - grain[k_y]) <= still_distance) &
                       (absolute(position[2] - grain[k_z]) <= still_distance);
    const Float sweeps = keep(still, minimum(grain[k_still_sweeps] + one, broadcast(a->still_sweeps)));
    if (item % k_lane_group == 0) a->still[group_number] = 1;
    if (any(and_not(inside, broadcast(a->still_sweeps) <= sweeps))) a->still[group_number] = 0;
    for (int k = 0; k < 3; ++k) {
      grain[k] = select(inside, position[k], grain[k]);
      grain[k_vx + k] = select(inside, velocity[k], grain[k_vx + k]);
    }
    grain[k_still_sweeps] = select(inside, sweeps, grain[k_still_sweeps]);
    store_records(record, grain);
  }
  extent->quarantined = quarantined;
}
