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

// The near pairs of particle i, or the others. `taken` are colours of each particle, in this class of pairs.
uint32_t colour_class(Granular* g, uint32_t i, bool far, uint32_t slot, uint32_t end) {
  PairColours& c = g->colours;
  const uint32_t rows = g->particles.rows, capacity = c.capacity, first_run = run_of(0, far, false);
  uint32_t* const taken = c.taken[far];
  uint32_t* const ends = c.ends;
  uint8_t* const runs = c.runs;
  uint32_t mine = taken[i], found = c.found, dropped = 0;
  for_pairs(*g, i, slot, end, [&](uint32_t j) {
    if (found == capacity) {
      ++dropped;
      return;
    }
    const bool fixed = j >= rows;
    const uint32_t free = ~(fixed ? mine : mine | taken[j]);
    uint8_t run = k_no_run;
    if (free != 0) {
      const uint32_t bit = free & (0u - free);
      mine |= bit;
      if (!fixed) taken[j] |= bit;
      run = static_cast<uint8_t>(first_run + 2 * static_cast<uint32_t>(__builtin_ctz(free)) + fixed);
      ++ends[run];
    } else {
      ++dropped;
    }
    runs[found++] = run;
  });
  taken[i] = mine;
  c.found = found;
  return dropped;
}

uint32_t colour_row(Granular* g, uint32_t i) {
  const uint32_t count = g->neighbours.counts[i], nears = g->neighbours.near_counts[i];
  return colour_class(g, i, false, 0, nears) + colour_class(g, i, true, nears, count);
}

void place_row(Granular* g, uint32_t i) {
  PairColours& c = g->colours;
  uint32_t *const first = c.first, *const second = c.second;
  const uint8_t* const runs = c.runs;
  const uint32_t capacity = c.capacity;
  uint32_t found = c.found;
  for_pairs(*g, i, 0, g->neighbours.counts[i], [&](uint32_t j) {
    if (found == capacity) return;
    const uint8_t run = runs[found++];
    if (run == k_no_run) return;
    const uint32_t at = c.ends[run]++;
    first[at] = i, second[at] = j;
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
  c->taken[0] = layout_region<uint32_t>(layout, "granular.near_colours", rows);
  c->taken[1] = layout_region<uint32_t>(layout, "granular.other_colours", rows);
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
    if (c.step == k_clear) c.taken[0][i] = c.taken[1][i] = 0;
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
