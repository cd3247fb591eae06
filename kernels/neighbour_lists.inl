// Neighbour lists from a sorted grid. Particles of one cell see the same 27 cells, so the candidates are copied once a cell into a
// small contiguous buffer and every particle of the cell is tested against it, a vector of candidates at a time. The order of a list is
// the order of the candidates: rows of cells by z, then y, then x, moving particles before boundary ones.

// Candidates of one cell. A vector beyond the end may be read and written; a buffer that is full is tested and emptied.
struct Candidates {
  static constexpr uint32_t k_capacity = 256;
  alignas(64) float x[k_capacity + 2 * k_lane_group];
  alignas(64) float y[k_capacity + 2 * k_lane_group];
  alignas(64) float z[k_capacity + 2 * k_lane_group];
  alignas(64) uint32_t index[k_capacity + 2 * k_lane_group];
  uint32_t count;
};

// A run of particles in one cell with the rows being filled.
struct Rows {
  uint32_t first, last;
  uint32_t used[k_lane_group];
  uint32_t dropped;
};

SANDGLASS_INLINE void test_candidates(const ListArgs* args, Candidates* candidates, Rows* rows) {
  const uint32_t n = candidates->count;
  const Float reach = broadcast(args->reach_squared);
  for (uint32_t i = rows->first; i < rows->last; ++i) {
    const Float x = broadcast(args->positions[0][i]), y = broadcast(args->positions[1][i]), z = broadcast(args->positions[2][i]);
    const Int self = broadcast(static_cast<int32_t>(i));
    alignas(64) uint32_t found[k_list_slots + 2 * k_lane_group];
    uint32_t* row = args->lists + static_cast<uint64_t>(i) * k_list_slots;
    uint32_t used = rows->used[i - rows->first];
    uint32_t extra = 0;
    uint32_t fresh = 0;  // found in this call; the row holds `used` already
    for (uint32_t c = 0; c < n; c += k_width) {
      const Int lane = lane_index() + broadcast(static_cast<int32_t>(c));
      const Int index = load(candidates->index + c);
      const Float dx = load(candidates->x + c) - x, dy = load(candidates->y + c) - y, dz = load(candidates->z + c) - z;
      const Float d2 = dx * dx + dy * dy + dz * dz;
      const Mask near = and_not((d2 < reach) & (lane < broadcast(static_cast<int32_t>(n))), index == self);
      fresh += compress_store(found + fresh, index, near);
      if (fresh > k_list_slots) {
        extra += fresh - k_list_slots;
        fresh = k_list_slots;
      }
    }
    const uint32_t room = k_list_slots - used;
    const uint32_t kept = fresh < room ? fresh : room;
    rows->dropped += extra + (fresh - kept);
    for (uint32_t s = 0; s < kept; ++s) row[used + s] = found[s];
    rows->used[i - rows->first] = used + kept;
  }
  candidates->count = 0;
}

SANDGLASS_INLINE void append_range(const ListArgs* args, const float* const* positions, uint32_t begin, uint32_t end, uint32_t first_record,
                                   Candidates* candidates, Rows* rows) {
  while (begin < end) {
    if (candidates->count == Candidates::k_capacity) test_candidates(args, candidates, rows);
    const uint32_t room = Candidates::k_capacity - candidates->count;
    const uint32_t n = end - begin < room ? end - begin : room;
    const uint32_t at = candidates->count;
    for (uint32_t c = 0; c < n; c += k_width) {
      store(candidates->x + at + c, load(positions[0] + begin + c));
      store(candidates->y + at + c, load(positions[1] + begin + c));
      store(candidates->z + at + c, load(positions[2] + begin + c));
      store(candidates->index + at + c, lane_index() + broadcast(static_cast<int32_t>(first_record + begin + c)));
    }
    candidates->count += n;
    begin += n;
  }
}

SANDGLASS_INLINE void append_neighbourhood(const ListArgs* args, const Grid& grid, const float* const* positions, uint32_t first_record,
                                           const int32_t cell[3], Candidates* candidates, Rows* rows) {
  const uint32_t mask[3] = {(1u << grid.bits[0]) - 1, (1u << grid.bits[1]) - 1, (1u << grid.bits[2]) - 1};
  const uint32_t left = static_cast<uint32_t>(cell[0] - 1) & mask[0];
  const uint32_t right = static_cast<uint32_t>(cell[0] + 1) & mask[0];
  for (int32_t dz = -1; dz <= 1; ++dz) {
    for (int32_t dy = -1; dy <= 1; ++dy) {
      const uint32_t row = (((static_cast<uint32_t>(cell[2] + dz) & mask[2]) << grid.bits[1]) | (static_cast<uint32_t>(cell[1] + dy) & mask[1]))
                           << grid.bits[0];
      if (left < right) {
        append_range(args, positions, grid.starts[row + left], grid.starts[row + right + 1], first_record, candidates, rows);
      } else {  // the row wraps round between these three cells
        for (int32_t dx = -1; dx <= 1; ++dx) {
          const uint32_t c = row + (static_cast<uint32_t>(cell[0] + dx) & mask[0]);
          append_range(args, positions, grid.starts[c], grid.starts[c + 1], first_record, candidates, rows);
        }
      }
    }
  }
}

SANDGLASS_INLINE int32_t floor_cell(float a, float inverse) {
  const float scaled = a * inverse;
  const int32_t truncated = static_cast<int32_t>(scaled);
  return scaled < static_cast<float>(truncated) ? truncated - 1 : truncated;
}

static void neighbour_lists(const ListArgs* args, uint32_t begin, uint32_t end, uint32_t* dropped) {
  Candidates candidates;
  candidates.count = 0;
  Rows rows;
  rows.dropped = 0;
  const float inverse = args->grid.inverse_cell;
  uint32_t i = begin;
  while (i < end) {
    const int32_t cell[3] = {floor_cell(args->positions[0][i], inverse), floor_cell(args->positions[1][i], inverse),
                             floor_cell(args->positions[2][i], inverse)};
    rows.first = i;
    do {
      rows.used[i - rows.first] = 0;
      ++i;
    } while (i < end && i - rows.first < k_lane_group && floor_cell(args->positions[0][i], inverse) == cell[0] &&
             floor_cell(args->positions[1][i], inverse) == cell[1] && floor_cell(args->positions[2][i], inverse) == cell[2]);
    rows.last = i;
    append_neighbourhood(args, args->grid, args->positions, 0, cell, &candidates, &rows);
    if (args->boundary_count != 0) {
      append_neighbourhood(args, args->boundary_grid, args->boundary_positions, args->boundary_first, cell, &candidates, &rows);
    }
    test_candidates(args, &candidates, &rows);
    for (uint32_t p = rows.first; p < rows.last; ++p) {
      uint32_t* row = args->lists + static_cast<uint64_t>(p) * k_list_slots;
      const uint32_t used = rows.used[p - rows.first];
      args->counts[p] = static_cast<uint8_t>(used);
      for (uint32_t s = used; s < k_list_slots; ++s) row[s] = args->inert;
    }
  }
  *dropped = rows.dropped;
}
