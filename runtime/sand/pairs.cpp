// Each contact once: pairs from the neighbour lists, in colours.
#include "runtime/sand/granular.h"

namespace sandglass {

namespace {

// Pairs a particle for which there is room, and as many again with the boundary. The densest packing has 9 within the
// longest reach, 3 r: 12 neighbours touch and 6 more are at 2.83 r, and a pair counts for both. The rest is for overlap.
constexpr uint64_t k_pairs_each = 12;

// Runs in order: near before far; of these by colour; of one colour those with the boundary last.
uint32_t run_of(uint32_t colour, bool far, bool fixed) { return (far ? 2 * k_pair_colours : 0) + 2 * colour + fixed; }

enum : uint32_t { k_clear, k_colour };

// Calls each(other) for the pairs of particle i in [slot, end) of its list that no other list holds as well.
template <class Each>
void for_pairs(const Granular& g, uint32_t i, uint32_t slot, uint32_t end, const Each& each) {
  const uint8_t* const listed = g.neighbours.listed;
  const uint32_t* const row = g.neighbours.lists + static_cast<uint64_t>(i) * k_list_slots;
  for (uint32_t s = slot; s < end; ++s) {
    const uint32_t j = row[s];
    if (j < i && listed[j / k_lane_group] != 0) continue;
    each(j);
  }
}

// Puts a pair behind the last one of its run. A run gets a group when its last one is full. False: there is no group.
bool put_pair(PairColours* c, uint32_t run, uint32_t i, uint32_t j) {
  uint32_t at = c->ends[run];
  if (at % k_lane_group == 0) {
    if (c->group_count == c->capacity) return false;
    c->runs[c->group_count] = static_cast<uint8_t>(run);
    at = k_lane_group * c->group_count++;
  }
  c->first[at] = i;
  c->second[at] = j;
  c->ends[run] = at + 1;
  return true;
}

// Colours the near pairs of particle i, or the others. Returns how many pairs had no place.
uint32_t colour_class(PairColours* colours, const Granular& g, uint32_t i, bool far, uint32_t slot, uint32_t end) {
  PairColours& c = *colours;
  const Neighbours& n = g.neighbours;
  const uint8_t* const listed = n.listed;
  const uint32_t* const row = n.lists + static_cast<uint64_t>(i) * k_list_slots;
  const uint32_t rows = g.particles.rows, first_run = run_of(0, far, false);
  uint32_t* const taken = c.taken[far];
  uint32_t own = taken[i], dropped = 0;
  for (uint32_t s = slot; s < end; ++s) {
    const uint32_t j = row[s];
    if (j < i && listed[j / k_lane_group] != 0) continue;  // the list of j holds the pair
    const bool fixed = j >= rows;
    const uint32_t free = ~(fixed ? own : own | taken[j]), bit = free & (0u - free);
    if (free == 0 || !put_pair(&c, first_run + 2 * static_cast<uint32_t>(__builtin_ctz(free)) + fixed, i, j)) {
      ++dropped;
      continue;
    }
    own |= bit;
    if (!fixed) taken[j] |= bit;
  }
  taken[i] = own;
  return dropped;
}

uint32_t colour_row(PairColours* c, const Granular& g, uint32_t i) {
  const uint32_t count = g.neighbours.counts[i], nears = g.neighbours.near_counts[i];
  return colour_class(c, g, i, false, 0, nears) + colour_class(c, g, i, true, nears, count);
}

// Fills the last group of each run with pairs that never touch: the inert particle and one of the last pair, which no
// other thread writes.
void fill_runs(PairColours* colours, uint32_t inert) {
  PairColours& c = *colours;
  for (const uint32_t end : c.ends) {
    for (uint32_t at = end; at % k_lane_group != 0; ++at) {
      c.first[at] = inert;
      c.second[at] = c.second[at - 1];
    }
  }
}

// Brings the groups into the order of their runs.
void order_groups(PairColours* c) {
  uint32_t places[k_pair_runs] = {}, at = 0;
  for (uint32_t group = 0; group < c->group_count; ++group) ++places[c->runs[group]];
  c->filled_count = 0;
  for (uint32_t run = 0; run < k_pair_runs; ++run) {
    const uint32_t count = places[run];
    if (count != 0) c->filled[c->filled_count++] = static_cast<uint8_t>(run);
    c->starts[run] = k_lane_group * at;
    places[run] = at;
    at += count;
  }
  c->starts[k_pair_runs] = k_lane_group * at;
  for (uint32_t group = 0; group < c->group_count; ++group) c->groups[places[c->runs[group]]++] = group;
}

}  // namespace

void pair_colours_layout(PairColours* c, const sandglass_granular_desc& d, uint32_t rows, Layout* layout) {
  const uint64_t pairs = k_pairs_each * rows * (d.boundary_capacity != 0 ? 2 : 1);
  c->capacity = static_cast<uint32_t>(pairs / k_lane_group + k_pair_runs);
  const uint64_t room = static_cast<uint64_t>(c->capacity) * k_lane_group;
  c->first = layout_region<uint32_t>(layout, "granular.pairs_first", room);
  c->second = layout_region<uint32_t>(layout, "granular.pairs_second", room);
  c->groups = layout_region<uint32_t>(layout, "granular.pair_groups", c->capacity);
  c->runs = layout_region<uint8_t>(layout, "granular.pair_runs", c->capacity);
  c->taken[0] = layout_region<uint32_t>(layout, "granular.near_colours", rows);
  c->taken[1] = layout_region<uint32_t>(layout, "granular.other_colours", rows);
}

void pair_colours_forget(PairColours* c) {
  c->ready = false;
  c->step = k_clear;
}

bool pair_colours_run(PairColours* colours, const Granular& g, uint32_t* cursor, FrameCounts* counts) {
  PairColours& c = *colours;
  const uint32_t count = g.particles.count, begin = *cursor, end = count - begin < g.unit ? count : begin + g.unit;
  if (c.step == k_clear) {
    for (uint32_t* const taken : c.taken) __builtin_memset(taken + begin, 0, (end - begin) * sizeof *taken);
  }
  uint32_t dropped = 0;
  for (uint32_t i = begin; c.step == k_colour && i < end; ++i) {
    if (g.neighbours.listed[i / k_lane_group] != 0) dropped += colour_row(&c, g, i);
  }
  counts->dropped_contacts += dropped;
  *cursor = end;
  if (end < count) return false;
  *cursor = 0;
  if (c.step == k_clear) {
    for (uint32_t& last : c.ends) last = 0;
    c.group_count = 0;
    c.step = k_colour;
    return false;
  }
  fill_runs(&c, g.particles.inert);
  order_groups(&c);
  c.step = k_clear;
  return c.ready = true;
}

uint32_t pair_count(const PairColours& c) { return c.starts[k_pair_runs]; }

uint32_t pair_unit(const PairColours& c, uint32_t items) {
  const uint32_t all = pair_count(c), limit = k_pairs_an_item * items, units = (all + limit - 1) / limit;
  if (units <= 1) return all;
  return ((all + units - 1) / units + k_lane_group - 1) / k_lane_group * k_lane_group;
}

PairPiece pair_piece(const PairColours& c, uint32_t done, uint32_t limit) {
  // Runs that hold no pairs begin and end at the same place.
  uint32_t low = 0, high = c.filled_count;
  while (high - low > 1) {
    const uint32_t middle = (low + high) / 2;
    if (c.starts[c.filled[middle]] <= done) low = middle;
    else high = middle;
  }
  const uint32_t run = c.filled[low], left = c.starts[run + 1] - done;
  return {done, done + (left < limit ? left : limit), run % 2 != 0};
}

}  // namespace sandglass
