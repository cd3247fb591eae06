// Neighbour lists from a sorted grid. Particles of one cell see the same 27 cells. The stored ranges of those are
// looked up once a cell, three cells of a row at a time. Every particle of the cell is then tested against them, a
// vector of candidates at a time. A list first has the neighbours that touch or soon may, then the others. Within each
// part it has the order of the candidates: moving particles before boundary ones, cells by z, then y, then x. A pass
// over the lists of a vector of particles therefore finds its contacts in the first slots and skips the arithmetic of
// the later ones.
//
// To gather the candidates of a cell into one dense buffer first was slower: the short overlapping stores stall the
// loads after them.

// Stored ranges of candidates near one cell: at most 9 rows of three cells, each in at most three pieces where the grid
// wraps round.
struct Ranges {
  static constexpr uint32_t k_capacity = 27;
  uint32_t begin[k_capacity], end[k_capacity];
  uint32_t count;
};

SANDGLASS_INLINE void add_range(Ranges* ranges, uint32_t begin, uint32_t end) {
  ranges->begin[ranges->count] = begin;
  ranges->end[ranges->count] = end;
  ranges->count += begin < end ? 1u : 0u;
}

SANDGLASS_INLINE void find_ranges(const Grid& grid, const int32_t cell[3], Ranges* ranges) {
  const uint32_t mask[3] = {(1u << grid.bits[0]) - 1, (1u << grid.bits[1]) - 1, (1u << grid.bits[2]) - 1};
  const uint32_t left = static_cast<uint32_t>(cell[0] - 1) & mask[0];
  const uint32_t right = static_cast<uint32_t>(cell[0] + 1) & mask[0];
  ranges->count = 0;
  for (int32_t dz = -1; dz <= 1; ++dz) {
    const uint32_t plane = (static_cast<uint32_t>(cell[2] + dz) & mask[2]) << grid.bits[1];
    for (int32_t dy = -1; dy <= 1; ++dy) {
      const uint32_t row = (plane | (static_cast<uint32_t>(cell[1] + dy) & mask[1])) << grid.bits[0];
      if (left < right) {
        add_range(ranges, grid.starts[row + left], grid.starts[row + right + 1]);
      } else {  // the row wraps round between these three cells
        for (int32_t dx = -1; dx <= 1; ++dx) {
          const uint32_t c = row + (static_cast<uint32_t>(cell[0] + dx) & mask[0]);
          add_range(ranges, grid.starts[c], grid.starts[c + 1]);
        }
      }
    }
  }
}

// Leaves out what ends before this particle.
SANDGLASS_INLINE void drop_ranges_before(uint32_t particle, Ranges* ranges) {
  uint32_t kept = 0;
  for (uint32_t r = 0; r < ranges->count; ++r) {
    if (ranges->end[r] <= particle) continue;
    ranges->begin[kept] = ranges->begin[r], ranges->end[kept++] = ranges->end[r];
  }
  ranges->count = kept;
}

// The list of one particle while it is filled. Behind the last slot is room for what compress_store writes there;
// neighbours that end up in that room are counted as dropped.
struct Row {
  alignas(64) uint32_t slots[k_list_slots + 2 * k_lane_group];
  // Squared distances as the bits of floats: they compare like the floats, because none is negative.
  alignas(64) uint32_t distances[k_list_slots + 2 * k_lane_group];
  uint32_t used;
  uint32_t dropped;
};

// Tests the candidates from `least` on.
SANDGLASS_INLINE void test_ranges(const Ranges& ranges, const float* const* positions, uint32_t first_record,
                                  uint32_t least, int32_t self, const float* at, Float reach, Row* row) {
  const Float x = broadcast(at[0]), y = broadcast(at[1]), z = broadcast(at[2]);
  const Int own = broadcast(self);
  for (uint32_t r = 0; r < ranges.count; ++r) {
    const Int end = broadcast(static_cast<int32_t>(ranges.end[r]));
    for (uint32_t c = ranges.begin[r] < least ? least : ranges.begin[r]; c < ranges.end[r]; c += k_width) {
      const Int index = lane_index() + broadcast(static_cast<int32_t>(c));
      const Float dx = load(positions[0] + c) - x, dy = load(positions[1] + c) - y, dz = load(positions[2] + c) - z;
      const Float d2 = dx * dx + dy * dy + dz * dz;
      const Mask chosen = and_not((d2 < reach) & (index < end), index == own);
      if (!any(chosen)) continue;
      compress_store(row->distances + row->used, as_int(d2), chosen);
      row->used +=
          compress_store(row->slots + row->used, index + broadcast(static_cast<int32_t>(first_record)), chosen);
      if (row->used > k_list_slots) {
        row->dropped += row->used - k_list_slots;
        row->used = k_list_slots;
      }
    }
  }
}

// Writes the near neighbours, then the others, then the index of the inert particle up to slot `end`. Returns the number
// of near ones.
SANDGLASS_INLINE uint32_t put_near_first(const Row& row, Int near2, Int inert, uint32_t end, uint32_t* out) {
  alignas(64) uint32_t ordered[k_list_slots + 2 * k_lane_group];
  const Int used = broadcast(static_cast<int32_t>(row.used));
  uint32_t count = 0, nears = 0;
  for (uint32_t far = 0; far < 2; ++far) {
    for (uint32_t s = 0; s < row.used; s += k_width) {
      const Mask filled = lane_index() + broadcast(static_cast<int32_t>(s)) < used;
      const Mask near = load(row.distances + s) < near2;
      count += compress_store(ordered + count, load(row.slots + s), far != 0 ? and_not(filled, near) : filled & near);
    }
    if (far == 0) nears = count;
  }
  for (uint32_t s = 0; s < end; s += k_width) {
    const Mask filled = lane_index() + broadcast(static_cast<int32_t>(s)) < used;
    store(out + s, select(filled, load(ordered + s), inert));
  }
  return nears;
}

SANDGLASS_INLINE int32_t floor_cell(float a, float inverse) {
  const float scaled = a * inverse;
  const int32_t truncated = to_whole<int32_t>(scaled);
  return scaled < static_cast<float>(truncated) ? truncated - 1 : truncated;
}

static void neighbour_lists(const ListArgs* args, uint32_t begin, uint32_t end, uint32_t* dropped) {
  const float inverse = args->grid.inverse_cell;
  const Float reach = broadcast(args->reach_squared);
  const Int near2 = as_int(broadcast(args->near_squared));
  const Int inert = broadcast(static_cast<int32_t>(args->inert));
  Ranges near = {}, boundary = {};
  Row row = {};
  int32_t cell[3] = {0, 0, 0};
  bool known = false;
  for (uint32_t i = begin; i < end; ++i) {
    const float at[3] = {args->positions[0][i], args->positions[1][i], args->positions[2][i]};
    const int32_t own[3] = {floor_cell(at[0], inverse), floor_cell(at[1], inverse), floor_cell(at[2], inverse)};
    if (!known || own[0] != cell[0] || own[1] != cell[1] || own[2] != cell[2]) {
      for (int k = 0; k < 3; ++k) cell[k] = own[k];
      known = true;
      find_ranges(args->grid, cell, &near);
      if (args->halves != 0) drop_ranges_before(i, &near);
      if (args->boundary_count != 0) find_ranges(args->boundary_grid, cell, &boundary);
    }
    row.used = 0;
    test_ranges(near, args->positions, 0, args->halves != 0 ? i + 1 : 0, static_cast<int32_t>(i), at, reach, &row);
    if (args->boundary_count != 0)
      test_ranges(boundary, args->boundary_positions, args->boundary_first, 0, -1, at, reach, &row);
    // Nobody reads beyond the used slots of a half.
    const uint32_t end_of_row = args->halves != 0 ? row.used : k_list_slots;
    uint32_t* out = args->lists + static_cast<uint64_t>(i) * k_list_slots;
    args->near_counts[i] = static_cast<uint8_t>(put_near_first(row, near2, inert, end_of_row, out));
    args->counts[i] = static_cast<uint8_t>(row.used);
  }
  *dropped = row.dropped;
}
