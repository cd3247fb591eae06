#include "runtime/granular/pair_colours.h"

#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

// Pairs a particle for which there is room, and as many again with the boundary. The densest packing has 9 within the
// longest reach, 3 r: 12 neighbours touch and 6 more are at 2.83 r, and a pair counts for both. The rest is for overlap.
constexpr uint64_t k_pairs_each = 12;

// Runs in order: near before far; of these by colour; of one colour those with the boundary last.
uint32_t run_of(uint32_t colour, bool far, bool fixed) { return (far ? 2 * k_pair_colours : 0) + 2 * colour + fixed; }

// The colouring walks over the lists twice: it colours pairs and counts those of each run, then puts them into their
// places.
enum : uint32_t { k_clear, k_colour, k_place };

constexpr uint8_t k_no_run = 255;  // of a pair for which no colour was left

// Calls each(index, far, other) for the pairs of particle i that no other list holds as well.
template <class Each>
void for_pairs(const Granular& g, uint32_t i, const Each& each) {
  const Neighbours& n = g.neighbours;
  const uint32_t* row = n.lists + static_cast<uint64_t>(i) * k_list_slots;
  const uint32_t count = n.counts[i], nears = n.near_counts[i];
  for (uint32_t s = 0; s < count; ++s) {
    const uint32_t j = row[s];
    if (j < i && n.listed[j / k_lane_group] != 0) continue;
    each(s >= nears, j);
  }
}

uint32_t colour_row(Granular* g, uint32_t i) {
  PairColours& c = g->colours;
  const uint32_t rows = g->particles.rows, capacity = c.capacity;
  uint64_t* const taken = c.taken;
  uint8_t* const runs = c.runs;
  uint64_t mine = taken[i];
  uint32_t found = c.found, dropped = 0;
  for_pairs(*g, i, [&](bool far, uint32_t j) {
    if (found == capacity) {
      ++dropped;
      return;
    }
    const bool fixed = j >= rows;
    const uint64_t both = fixed ? mine : mine | taken[j];
    const uint32_t shift = far ? k_pair_colours : 0, free = ~static_cast<uint32_t>(both >> shift);
    uint8_t run = k_no_run;
    if (free != 0) {
      const uint32_t colour = static_cast<uint32_t>(__builtin_ctz(free));
      const uint64_t bit = 1ull << (colour + shift);
      mine |= bit;
      if (!fixed) taken[j] |= bit;
      run = static_cast<uint8_t>(run_of(colour, far, fixed));
      ++c.ends[run];
    } else {
      ++dropped;
    }
    runs[found++] = run;
  });
  taken[i] = mine;
  c.found = found;
  return dropped;
}

void place_row(Granular* g, uint32_t i) {
  PairColours& c = g->colours;
  uint32_t found = c.found;
  for_pairs(*g, i, [&](bool, uint32_t j) {
    if (found == c.capacity) return;
    const uint8_t run = c.runs[found++];
    if (run == k_no_run) return;
    const uint32_t at = c.ends[run]++;
    c.first[at] = i, c.second[at] = j;
  });
  c.found = found;
}

// Between the walks: every run gets its place.
void place_runs(PairColours* c) {
  uint32_t at = 0;
  c->filled_count = 0;
  for (uint32_t run = 0; run < k_pair_runs; ++run) {
    const uint32_t count = c->ends[run];
    if (count != 0) c->filled[c->filled_count++] = static_cast<uint8_t>(run);
    c->starts[run] = c->ends[run] = at;
    at += (count + k_lane_group - 1) / k_lane_group * k_lane_group;
  }
  c->starts[k_pair_runs] = at;
  c->found = 0;
}

// Fills each run with pairs that never touch: the inert particle and one of the last pair, which no other thread writes.
void fill_runs(Granular* g) {
  PairColours& c = g->colours;
  for (uint32_t run = 0; run < k_pair_runs; ++run) {
    for (uint32_t at = c.ends[run]; at < c.starts[run + 1]; ++at)
      c.first[at] = g->particles.inert, c.second[at] = c.second[at - 1];
  }
}

}  // namespace

void pair_colours_layout(PairColours* c, const sandglass_granular_desc& d, uint32_t rows, Layout* layout) {
  c->capacity = static_cast<uint32_t>(k_pairs_each * rows * (d.boundary_capacity != 0 ? 2 : 1));
  const uint64_t room = c->capacity + k_pair_runs * k_lane_group;
  c->first = layout_region<uint32_t>(layout, "granular.pairs_first", room);
  c->second = layout_region<uint32_t>(layout, "granular.pairs_second", room);
  c->runs = layout_region<uint8_t>(layout, "granular.pair_runs", c->capacity);
  c->taken = layout_region<uint64_t>(layout, "granular.pair_colours", rows);
}

void pair_colours_forget(PairColours* c) {
  c->ready = false;
  c->step = k_clear;
}

bool pair_colours_run(Granular* g) {
  PairColours& c = g->colours;
  uint32_t& cursor = g->substep.cursor;
  const uint32_t count = g->particles.count, begin = cursor, end = count - begin < g->unit ? count : begin + g->unit;
  uint32_t dropped = 0;
  for (uint32_t i = begin; i < end; ++i) {
    if (c.step == k_clear) c.taken[i] = 0;
    else if (g->neighbours.listed[i / k_lane_group] == 0) continue;
    else if (c.step == k_colour) dropped += colour_row(g, i);
    else place_row(g, i);
  }
  g->counts.dropped_contacts += dropped;
  cursor = end;
  if (end < count) return false;
  cursor = 0;
  switch (c.step++) {
    case k_clear:
      for (uint32_t& size : c.ends) size = 0;
      c.found = 0;
      return false;
    case k_colour:
      place_runs(&c);
      return false;
    default:
      fill_runs(g);
      c.step = k_clear;
      return c.ready = true;
  }
}

uint32_t pair_count(const PairColours& c) { return c.starts[k_pair_runs]; }

uint32_t pair_unit(const PairColours& c, uint32_t items) {
  const uint32_t all = pair_count(c), most = k_pairs_an_item * items, units = (all + most - 1) / most;
  if (units <= 1) return all;
  return ((all + units - 1) / units + k_lane_group - 1) / k_lane_group * k_lane_group;
}

PairPiece pair_piece(const PairColours& c, uint32_t done, uint32_t most) {
  uint32_t before = 0;
  for (uint32_t at = 0; at < c.filled_count; ++at) {
    const uint32_t run = c.filled[at];
    const uint32_t length = c.starts[run + 1] - c.starts[run];
    if (done - before < length) {
      const uint32_t begin = c.starts[run] + (done - before), left = c.starts[run + 1] - begin;
      return {begin, begin + (left < most ? left : most), run % 2 != 0};
    }
    before += length;
  }
  return {};
}

}  // namespace sandglass
