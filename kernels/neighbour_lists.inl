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

// Adds what of [begin, end) comes from `first` on.
SANDGLASS_INLINE void add_range(Ranges* ranges, uint32_t begin, uint32_t end, uint32_t first) {
  const uint32_t from = begin < first ? first : begin;
  ranges->begin[ranges->count] = from;
  ranges->end[ranges->count] = end;
  ranges->count += from < end ? 1u : 0u;
}

// Where the storage of the nine rows begins that hold a cell and its neighbours.
struct Rows {
  uint32_t begin[9];
};

SANDGLASS_INLINE void find_rows(const Grid& grid, const int32_t cell[3], Rows* rows) {
  const uint32_t mask_y = (1u << grid.bits[1]) - 1, mask_z = (1u << grid.bits[2]) - 1;
  for (uint32_t at = 0; at < 9; ++at) {
    const uint32_t y = (static_cast<uint32_t>(cell[1]) + at % 3 - 1) & mask_y;
    const uint32_t z = (static_cast<uint32_t>(cell[2]) + at / 3 - 1) & mask_z;
    rows->begin[at] = ((z << grid.bits[1]) | y) << grid.bits[0];
  }
}

// Apart, since it is inlined twice and unrolled else.
SANDGLASS_NOINLINE void find_ranges(const Grid& grid, const Rows& rows, int32_t cell_x, uint32_t first,
                                    Ranges* ranges) {
  const uint32_t mask = (1u << grid.bits[0]) - 1;
  const uint32_t middle = static_cast<uint32_t>(cell_x), left = (middle - 1) & mask, right = (middle + 1) & mask;
  ranges->count = 0;
  if (left < right) {
    const uint32_t* const starts = grid.starts + left;
    for (const uint32_t row : rows.begin) add_range(ranges, starts[row], starts[row + 3], first);
    return;
  }
  for (const uint32_t row : rows.begin) {  // the rows wrap round between the three cells
    for (uint32_t dx = 0; dx < 3; ++dx) {
      const uint32_t x = row + ((left + dx) & mask);
      add_range(ranges, grid.starts[x], grid.starts[x + 1], first);
    }
  }
}

// The list of one particle while it is filled. Behind the last slot is room for what compress_store writes there;
// neighbours that end up in that room are counted as dropped.
struct Row {
  static constexpr uint32_t k_capacity = k_list_slots + k_lane_group;
  alignas(64) uint32_t nears[k_list_slots + k_capacity];  // with room for the others behind them
  alignas(64) uint32_t others[k_capacity];
  uint32_t near_count, other_count;
  uint32_t dropped;
};

SANDGLASS_INLINE void limit_to(uint32_t limit, uint32_t* count, uint32_t* dropped) {
  if (*count <= limit) return;
  *dropped += *count - limit;
  *count = limit;
}

// Of eight candidates or more one is in reach so often that a branch is mispredicted more than it saves.
constexpr bool k_skips_empty = k_width < 8;

// Tests the candidates from `first` on.
SANDGLASS_INLINE void test_ranges(const Ranges& ranges, const float* const* positions, uint32_t first_record,
                                  uint32_t first, int32_t self, const float* at, Float reach, Float near, Row* row) {
  const Float x = broadcast(at[0]), y = broadcast(at[1]), z = broadcast(at[2]);
  uint32_t nears = row->near_count, others = row->other_count;  // not in memory: the stores below might change it
  for (uint32_t r = 0; r < ranges.count; ++r) {
    const uint32_t end = ranges.end[r];
    for (uint32_t c = ranges.begin[r] < first ? first : ranges.begin[r]; c < end; c += k_width) {
      const Float dx = load(positions[0] + c) - x, dy = load(positions[1] + c) - y, dz = load(positions[2] + c) - z;
      const Float d2 = dx * dx + dy * dy + dz * dz;
      const Mask within = d2 < reach;
      if (k_skips_empty && __builtin_expect(!any(within), 1)) continue;
      const Int index = lane_index() + broadcast(static_cast<int32_t>(c));
      const Mask chosen = and_not(within & (index < broadcast(static_cast<int32_t>(end))), index == broadcast(self));
      const Int record = index + broadcast(static_cast<int32_t>(first_record));
      const Mask close = d2 < near;
      nears += compress_store(row->nears + nears, record, chosen & close);
      others += compress_store(row->others + others, record, and_not(chosen, close));
      if (nears + others <= k_list_slots) continue;
      limit_to(k_list_slots, &nears, &row->dropped);
      limit_to(k_list_slots, &others, &row->dropped);
    }
  }
  row->near_count = nears;
  row->other_count = others;
}

// Writes the near neighbours, then the others, then the index of the inert particle up to slot `end`.
SANDGLASS_INLINE void put_row(Row* row, Int inert, bool whole, uint32_t* out, uint8_t* count, uint8_t* near_count) {
  limit_to(k_list_slots - row->near_count, &row->other_count, &row->dropped);
  const uint32_t used = row->near_count + row->other_count;
  for (uint32_t s = 0; s < row->other_count; s += k_width)
    store(row->nears + row->near_count + s, load(row->others + s));
  for (uint32_t s = 0; s < used; s += k_width) store(out + s, load(row->nears + s));
  for (uint32_t s = used / k_width * k_width; whole && s < k_list_slots; s += k_width) {
    const Mask filled = lane_index() + broadcast(static_cast<int32_t>(s)) < broadcast(static_cast<int32_t>(used));
    store(out + s, select(filled, load(row->nears + s), inert));
  }
  *count = static_cast<uint8_t>(used);
  *near_count = static_cast<uint8_t>(row->near_count);
}

// Cells wrap around, and so may their numbers: floor_whole, which bounds them, makes lists 2 % dearer.
SANDGLASS_INLINE int32_t floor_cell(float a, float inverse) {
  const float scaled = a * inverse;
  const int32_t truncated = to_whole<int32_t>(scaled);
  const uint32_t below = scaled < static_cast<float>(truncated) ? 1 : 0;
  return static_cast<int32_t>(static_cast<uint32_t>(truncated) - below);
}

static void neighbour_lists(const ListArgs* args, uint32_t begin, uint32_t end, uint32_t* dropped) {
  const float inverse = args->grid.inverse_cell;
  const Float reach = broadcast(args->reach_squared), near = broadcast(args->near_squared);
  const Int inert = broadcast(static_cast<int32_t>(args->inert));
  const bool halves = args->halves != 0, bounded = args->boundary_count != 0;
  Rows rows = {}, boundary_rows = {};
  Ranges ranges = {}, boundary = {};
  Row row = {};
  int32_t cell[3] = {0, 0, 0};
  for (uint32_t i = begin; i < end; ++i) {
    const float at[3] = {args->positions[0][i], args->positions[1][i], args->positions[2][i]};
    const int32_t own[3] = {floor_cell(at[0], inverse), floor_cell(at[1], inverse), floor_cell(at[2], inverse)};
    const bool other_row = i == begin || own[1] != cell[1] || own[2] != cell[2];
    if (other_row) {
      find_rows(args->grid, own, &rows);
      if (bounded) find_rows(args->boundary_grid, own, &boundary_rows);
    }
    if (other_row || own[0] != cell[0]) {
      find_ranges(args->grid, rows, own[0], halves ? i + 1 : 0, &ranges);
      if (bounded) find_ranges(args->boundary_grid, boundary_rows, own[0], 0, &boundary);
    }
    for (int k = 0; k < 3; ++k) cell[k] = own[k];
    row.near_count = row.other_count = 0;
    test_ranges(ranges, args->positions, 0, halves ? i + 1 : 0, static_cast<int32_t>(i), at, reach, near, &row);
    if (bounded) test_ranges(boundary, args->boundary_positions, args->boundary_first, 0, -1, at, reach, near, &row);
    // Nobody reads beyond the used slots of a half.
    put_row(&row, inert, !halves, args->lists + static_cast<uint64_t>(i) * k_list_slots, &args->counts[i],
            &args->near_counts[i]);
  }
  *dropped = row.dropped;
}
