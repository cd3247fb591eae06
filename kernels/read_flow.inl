// The flow of the particles at grains: sums over the particles near a lane, from the particles themselves or between
// the nodes of the motion grid. Lane = grain. Grains are sorted by cell, so k_width neighbouring lanes share almost all
// candidates. The candidates are found once for such a group of lanes, by their distance to the group's bounding box,
// and each is then broadcast to all lanes.
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

// The sums at the lanes that `lanes` holds, from the particles. Lanes that are far apart are gathered separately.
SANDGLASS_NOINLINE void gather_all(const RefineArgs* a, Mask lanes, const Float position[3], Flow* flow) {
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
SANDGLASS_NOINLINE void find_lacking(const MotionGrid* grid, Mask lanes, const uint32_t* numbers, Places* places) {
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
  const bool single = find_blocks(grid, lanes, place, last, numbers);
  places->known = lanes;
  places->lacking = and_not(lanes, lanes);
  if (single && last->number != k_no_block && grid->overflowed == 0) {
    const uint8_t* density = density_of(*grid, last->number);
    // Lanes that are not asked for have coordinates of 0 and so a corner of the block too.
    store(records, corner + broadcast(static_cast<int32_t>(last->number * k_block_records)));
    for (uint32_t l = 0; l < k_width; ++l) {
      places->records[l] = grid->nodes + uint64_t{records[l]} * k_record_floats;
      places->density[l] = density;
    }
    return;
  }
  if (single) store(numbers, broadcast(static_cast<int32_t>(last->number)));
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
