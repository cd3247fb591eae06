// The motion of the particles on the nodes of a sparse grid, from which the grains read it.
//
// A particle adds its weight W and its momentum W u to every node within reach. It becomes the node's nearest particle
// where it is. Lane = node, and a node takes the particles in their order, so the lane count does not change a sum. The
// grid is made of blocks of 4 x 4 x 4 nodes, which exist where there are particles. An open hash table finds a block by
// its coordinates.

// Sets the planes of a new block: no weight, and the nearest particle far from everything.
SANDGLASS_INLINE void clear_block(float* planes) {
  const Float zero = broadcast(0.0f), far = broadcast(k_inert_position);
  for (uint32_t c = 0; c < k_block_nodes; c += k_width) {
    for (uint32_t plane = 0; plane < k_block_planes; ++plane)
      store(planes + plane * k_block_nodes + c, plane >= k_node_nearest && plane < k_node_number ? far : zero);
  }
}

SANDGLASS_INLINE bool is_at(const MotionBlock& block, const int32_t at[3]) {
  return block.at[0] == at[0] && block.at[1] == at[1] && block.at[2] == at[2];
}

// The block at `at`, made where there was none; k_no_block: there is no room for it.
SANDGLASS_INLINE uint32_t take_block(MotionGrid* grid, const int32_t at[3]) {
  uint32_t slot = motion_hash(at[0], at[1], at[2]) & grid->slot_mask;
  for (; grid->slots[slot] != 0; slot = (slot + 1) & grid->slot_mask) {
    const uint32_t number = grid->slots[slot] - 1;
    if (is_at(grid->blocks[number], at)) return number;
  }
  if (grid->block_count == grid->block_capacity) {
    grid->overflowed = 1;
    return k_no_block;
  }
  const uint32_t number = grid->block_count++;
  grid->slots[slot] = number + 1;
  MotionBlock& block = grid->blocks[number];
  for (int k = 0; k < 3; ++k) block.at[k] = at[k];
  block.state = 0;
  __builtin_memset(block.around, 0xff, sizeof block.around);
  block.around[k_itself] = number;
  clear_block(grid->planes + static_cast<uint64_t>(number) * k_block_floats);
  __builtin_memset(grid->counts + static_cast<uint64_t>(number) * k_block_counts, 0, k_block_counts);
  return number;
}

// Adds a particle to the nodes of a block that lie from `low` to `high`, which count from the block's first node.
SANDGLASS_INLINE void add_to_block(const MotionGrid* grid, const MotionBlock& block, float* planes,
                                   const int32_t low[3], const int32_t high[3], const float position[3],
                                   const float velocity[3], float index) {
  constexpr uint32_t k_rows = k_width < k_block_side ? 1 : k_width / k_block_side;  // of nodes that a vector holds
  const Float zero = broadcast(0.0f), h2 = broadcast(grid->reach * grid->reach), gain = broadcast(grid->gain),
              inverse = broadcast(1.0f / (grid->reach * grid->reach)), spacing = broadcast(grid->spacing);
  const Int side = broadcast(static_cast<int32_t>(k_block_side - 1));
  const Int origin[3] = {broadcast(block.at[0] * 4), broadcast(block.at[1] * 4), broadcast(block.at[2] * 4)};
  const Float p[3] = {broadcast(position[0]), broadcast(position[1]), broadcast(position[2])};
  constexpr int32_t k_step_y = static_cast<int32_t>(k_rows);
  for (int32_t z = low[2]; z <= high[2]; ++z) {
    const Float dz = to_float(origin[2] + broadcast(z)) * spacing - p[2];
    for (int32_t y = k_rows >= k_block_side ? 0 : low[1] / k_step_y * k_step_y; y <= high[1]; y += k_step_y) {
      const int32_t first_x = k_width < k_block_side ? low[0] : 0, last_x = k_width < k_block_side ? high[0] : 0;
      for (int32_t x = first_x; x <= last_x; ++x) {
        const uint32_t at = static_cast<uint32_t>((z * 4 + y) * 4 + x);
        const Int lane = lane_index() + broadcast(x);
        const Int column = lane & side;
        const Float dx = to_float(origin[0] + column) * spacing - p[0];
        const Float row = to_float(lane - column) * broadcast(0.25f);
        const Float dy = (to_float(origin[1] + broadcast(y)) + row) * spacing - p[1];
        const Float d2 = dx * dx + dy * dy + dz * dz;
        if (!any(d2 < h2)) continue;
        const Float t = maximum((h2 - d2) * inverse, zero);
        const Float weight = gain * (t * t * t);
        float* node = planes + at;
        const Float largest = load(node + k_node_largest * k_block_nodes);
        const Mask nearer = largest < weight;
        for (uint32_t k = 0; k < 3; ++k) {
          float* nearest = node + (k_node_nearest + k) * k_block_nodes;
          float* momentum = node + (k_node_momentum + k) * k_block_nodes;
          store(nearest, select(nearer, p[k], load(nearest)));
          store(momentum, load(momentum) + weight * broadcast(velocity[k]));
        }
        store(node, load(node) + weight);
        float* number = node + k_node_number * k_block_nodes;
        store(number, select(nearer, broadcast(index), load(number)));
        store(node + k_node_largest * k_block_nodes, maximum(weight, largest));
      }
    }
  }
}

// Blocks by whether their coordinates are odd: those of the last particles.
struct RecentBlocks {
  uint32_t numbers[8];
};

SANDGLASS_INLINE uint32_t recent_block(MotionGrid* grid, const int32_t at[3], RecentBlocks* recent) {
  uint32_t* number = &recent->numbers[(at[0] & 1) | (at[1] & 1) << 1 | (at[2] & 1) << 2];
  if (*number == k_no_block || !is_at(grid->blocks[*number], at)) *number = take_block(grid, at);
  return *number;
}

static void scatter_motion(const ScatterMotionArgs* a, uint32_t begin, uint32_t end, uint32_t* result) {
  (void)result;
  MotionGrid* grid = a->grid;
  const float reach = grid->reach * grid->inverse_spacing;
  RecentBlocks recent;
  for (uint32_t& number : recent.numbers) number = k_no_block;
  for (uint32_t i = begin; i < end && i < a->particle_count; ++i) {
    const Particle& particle = a->particles[i];
    if (in_body(particle)) continue;
    float position[3];
    int32_t first[3], last[3];
    for (int k = 0; k < 3; ++k) {
      position[k] = particle.position[k] - a->time * particle.velocity[k] - grid->origin[k];
      const float scaled = position[k] * grid->inverse_spacing;
      first[k] = floor_whole(scaled - reach) + 1;
      last[k] = floor_whole(scaled + reach);
    }
    int32_t at[3], low[3], high[3];
    for (at[2] = first[2] >> 2; at[2] <= last[2] >> 2; ++at[2]) {
      for (at[1] = first[1] >> 2; at[1] <= last[1] >> 2; ++at[1]) {
        for (at[0] = first[0] >> 2; at[0] <= last[0] >> 2; ++at[0]) {
          if (a->wanted != nullptr && !place_in(*a->wanted, at[0], at[1], at[2])) continue;
          const uint32_t number = recent_block(grid, at, &recent);
          if (number == k_no_block) continue;
          for (int k = 0; k < 3; ++k) {
            const int32_t from = first[k] - 4 * at[k], to = last[k] - 4 * at[k];
            low[k] = from > 0 ? from : 0;
            high[k] = to < 3 ? to : 3;
          }
          if (a->read != nullptr && !place_in(*a->read, at[0], at[1], at[2])) continue;
          add_to_block(grid, grid->blocks[number], grid->planes + static_cast<uint64_t>(number) * k_block_floats, low,
                       high, position, particle.velocity, static_cast<float>(i));
        }
      }
    }
  }
}

// Where positions are in their blocks.
struct BlockPlace {
  Float block[3];   // coordinates of the block
  Float inside[3];  // from its first node, in nodes: 0..4
};

// Where the grid is, in every lane.
struct GridPlace {
  Float origin[3], inverse_spacing;
};

SANDGLASS_INLINE GridPlace place_of(const MotionGrid* grid) {
  return {{broadcast(grid->origin[0]), broadcast(grid->origin[1]), broadcast(grid->origin[2])},
          broadcast(grid->inverse_spacing)};
}

// A lane that `lanes` holds is not beyond k_coordinate_bound, so its place is within 2e7 nodes.
SANDGLASS_INLINE BlockPlace place_in_block(const GridPlace& grid, Mask lanes, const Float position[3]) {
  BlockPlace place;
  for (int k = 0; k < 3; ++k) {
    const Float scaled = keep(lanes, position[k] - grid.origin[k]) * grid.inverse_spacing;
    place.block[k] = to_float(floor_int(scaled * broadcast(0.25f)));
    place.inside[k] = scaled - broadcast(4.0f) * place.block[k];
  }
  return place;
}

SANDGLASS_INLINE Mask same_block(const BlockPlace& place, const Float block[3]) {
  return (place.block[0] == block[0]) & (place.block[1] == block[1]) & (place.block[2] == block[2]);
}

// The block of the last grains: as a rule the next ones are in it too, or in one beside it.
struct LastBlock {
  Float at[3];      // the same in every lane
  uint32_t number;  // or k_no_block
};

// No grain is in it.
SANDGLASS_INLINE LastBlock no_block_yet() {
  const Float nowhere = broadcast(3e9f);
  return {{nowhere, nowhere, nowhere}, k_no_block};
}

// Looks up every block of the lanes, which may be far apart.
SANDGLASS_NOINLINE void look_up_blocks(const MotionGrid* grid, Mask lanes, const BlockPlace& place, LastBlock* last,
                                       uint32_t* numbers) {
  alignas(64) float at[3][k_lane_group];
  for (int k = 0; k < 3; ++k) store(at[k], place.block[k]);
  store(numbers, broadcast(static_cast<int32_t>(k_no_block)));
  for (Mask left = lanes; any(left);) {
    const uint32_t sole = first(left);
    for (int k = 0; k < 3; ++k) last->at[k] = broadcast(at[k][sole]);
    last->number = motion_find(*grid, to_whole<int32_t>(at[0][sole]), to_whole<int32_t>(at[1][sole]),
                               to_whole<int32_t>(at[2][sole]));
    const Mask same = left & same_block(place, last->at);
    left = and_not(left, same);
    store(numbers, select(same, broadcast(static_cast<int32_t>(last->number)), load(numbers)));
  }
}

// Whether all lanes are in the last block; else the numbers of the lanes' blocks, of which one is then the last. Lanes
// that `lanes` does not hold get any number.
SANDGLASS_INLINE bool find_blocks(const MotionGrid* grid, Mask lanes, const BlockPlace& place, LastBlock* last,
                                  uint32_t* numbers) {
  if (!any(and_not(lanes, same_block(place, last->at)))) return true;
  if (last->number != k_no_block) {
    Float step[3];
    for (int k = 0; k < 3; ++k) step[k] = keep(lanes, place.block[k] - last->at[k]);
    const Float limit = broadcast(1.5f);
    if (all(within(step[0], limit) & within(step[1], limit) & within(step[2], limit))) {
      const Float side = broadcast(3.0f);
      const Int at = to_int((step[2] * side + step[1]) * side + step[0] + broadcast(static_cast<float>(k_itself)));
      const uint32_t* around = grid->blocks[last->number].around;
      store(numbers, at);
      for (uint32_t l = 0; l < k_width; ++l) numbers[l] = around[numbers[l]];
      const uint32_t next = numbers[k_width - 1];
      if (next != k_no_block) {
        const MotionBlock& block = grid->blocks[next];
        for (int k = 0; k < 3; ++k) last->at[k] = broadcast(static_cast<float>(block.at[k]));
        last->number = next;
      }
      return false;
    }
  }
  BlockPlace places;  // a copy, so that the original can stay in registers
  for (int k = 0; k < 3; ++k) {
    places.block[k] = place.block[k];
    places.inside[k] = place.inside[k];
  }
  look_up_blocks(grid, lanes, places, last, numbers);
  return false;
}

// Adds a grain to a cell of a block.
SANDGLASS_INLINE void count_grain(uint8_t* count) {
  *count = static_cast<uint8_t>(*count < 256 - k_grain_count ? *count + k_grain_count : *count);
}

static void count_grains(const CountGrainsArgs* a, uint32_t begin, uint32_t end, uint32_t* result) {
  (void)result;
  const MotionGrid* grid = a->grid;
  const Float limit = broadcast(k_coordinate_bound);
  const Int last_cell = broadcast(static_cast<int32_t>(k_block_cells - 1));
  MotionBlock* const blocks = grid->blocks;
  uint8_t* const all_counts = grid->counts;
  const GridPlace grid_place = place_of(grid);
  LastBlock last = no_block_yet();
  for (uint32_t i = begin; i < end; i += k_width) {
    Float grain[k_record_floats];
    load_records(floats_of(a->grains + i), grain);
    const Mask lanes =
        (lane_index() + broadcast(static_cast<int32_t>(i)) < broadcast(static_cast<int32_t>(a->grain_count))) &
        within(grain[k_x], limit) & within(grain[k_y], limit) & within(grain[k_z], limit);
    if (!any(lanes)) continue;
    const BlockPlace place = place_in_block(grid_place, lanes, grain);
    Int cell = broadcast(0);
    for (int k = 2; k >= 0; --k)
      cell = shift_left(cell, 3) + shift_left(cell, 2) + minimum(to_int(place.inside[k] * broadcast(3.0f)), last_cell);
    alignas(64) uint32_t cells[2 * k_lane_group], numbers[k_lane_group];
    const bool single = find_blocks(grid, lanes, place, &last, numbers);
    if (single && last.number == k_no_block) continue;
    store(cells, cell);
    if (single && all(lanes)) {
      blocks[last.number].state |= k_block_holds;
      uint8_t* counts = all_counts + static_cast<uint64_t>(last.number) * k_block_counts;
      for (uint32_t l = 0; l < k_width; ++l) count_grain(counts + cells[l]);
      continue;
    }
    if (single) store(numbers, broadcast(static_cast<int32_t>(last.number)));
    const Mask counted = and_not(lanes, load(numbers) == broadcast(static_cast<int32_t>(k_no_block)));
    const bool some = !all(counted);
    alignas(64) uint32_t chosen[k_lane_group];
    if (some) store(chosen, select(counted, broadcast(1), broadcast(0)));
    for (uint32_t l = 0; l < k_width; ++l) {
      if (some && chosen[l] == 0) continue;
      blocks[numbers[l]].state |= k_block_holds;
      count_grain(all_counts + static_cast<uint64_t>(numbers[l]) * k_block_counts + cells[l]);
    }
  }
}
