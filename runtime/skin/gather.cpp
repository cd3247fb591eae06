// Sand and colliders are taken at one moment: a skin may need more than a frame, and sand goes on with what holds it.
//
// Sand that has moved is taken out of the sums where it was and put in where it is. A particle is spread
// over the eight nodes about it, in whole numbers, so that what was put in can be taken out again exactly.
//
// What falls is no part of the surface: a particle counts less the faster it comes down to what is below it.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_falls_from = 0.5f, k_falls_over = 0.3f, k_flies = 0.35f;  // m/s
constexpr uint32_t k_unit_taken = 16'000;  // particles of which places are taken in a unit

// Adds a particle's share to the sums, or takes it away (sign -1).
void spread(SkinBricks* bricks, uint32_t number, const SkinParticle& p, uint32_t sign) {
  uint32_t far[3], local[3];
  for (uint32_t a = 0; a < 3; ++a) {
    far[a] = static_cast<uint32_t>(p.at[a] & (k_skin_steps - 1));
    local[a] = node_along(p.at[a] >> k_skin_step_shift);
  }
  constexpr uint32_t k_round = 3 * k_skin_step_shift - k_skin_one_shift;
  const uint32_t share = sign * p.share;
  const uint32_t wx[2] = {k_skin_steps - far[0], far[0]}, wy[2] = {k_skin_steps - far[1], far[1]};
  const uint32_t wz[2] = {k_skin_steps - far[2], far[2]};
  const Brick& own = bricks->records[number];
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t x = local[0] + (c & 1), z = local[2] + (c >> 1 & 1), y = local[1] + (c >> 2);
    const uint32_t brick = own.around[brick_around(x, y, z)];
    bricks->nodes[brick].sums[node_index(node_along(x), node_along(y), node_along(z))] +=
        (wx[c & 1] * wy[c >> 2] * wz[c >> 1 & 1] >> k_round) * share;
  }
  // The density of the nodes beside those changes, too: up to the second one after the cell.
  uint32_t first[3], last[3];
  for (uint32_t a = 0; a < 3; ++a) {
    first[a] = local[a] == 0 ? 0 : 1;
    last[a] = local[a] + 2 >= k_brick_side ? 2 : 1;
  }
  for (uint32_t y = first[1]; y <= last[1]; ++y)
    for (uint32_t z = first[2]; z <= last[2]; ++z)
      for (uint32_t x = first[0]; x <= last[0]; ++x) {
        const uint32_t brick = own.around[around_index(x, y, z)];
        if (brick != k_none) bricks->records[brick].stale |= k_stale_density | k_stale_mesh;
      }
}

// The cell of a particle, and the brick of that cell.
void cell_of(const SkinParticle& p, int32_t cell[3], int32_t at[3]) {
  for (uint32_t a = 0; a < 3; ++a) {
    cell[a] = p.at[a] >> k_skin_step_shift;
    at[a] = brick_along(cell[a]);
  }
}

void take_out(SkinSand* sand, SkinBricks* bricks, uint32_t number) {
  SkinParticle& p = sand->particles[number];
  if (p.share == 0) return;
  int32_t cell[3], at[3];
  cell_of(p, cell, at);
  const uint32_t brick = brick_find(*bricks, at);
  spread(bricks, brick, p, ~0u);
  --bricks->records[brick].touches;
  if (p.next != k_none) sand->particles[p.next].last = p.last;
  if (p.last != k_none) sand->particles[p.last].next = p.next;
  else bricks->nodes[brick].particles[node_of(cell)] = p.next;
  p.share = 0;
  p.moved = sand->cycle;
}

// The bricks of the eight nodes about a cell, made where they are not there. k_none: there is no room for all.
uint32_t make_room(SkinBricks* bricks, const int32_t cell[3], const int32_t at[3]) {
  const uint32_t brick = brick_make(bricks, at);
  if (brick == k_none) return brick;
  constexpr uint32_t k_last = k_brick_side - 1;
  const bool ends[3] = {node_along(cell[0]) == k_last, node_along(cell[1]) == k_last, node_along(cell[2]) == k_last};
  for (uint32_t c = 1; c < 8; ++c) {
    const uint32_t x = c & 1, z = c >> 1 & 1, y = c >> 2;
    if ((x != 0 && !ends[0]) || (z != 0 && !ends[2]) || (y != 0 && !ends[1])) continue;
    const uint32_t around = around_index(1 + x, 1 + y, 1 + z);
    if (bricks->records[brick].around[around] != k_none) continue;
    int32_t other[3];
    brick_beside(at, around, other);
    if (brick_make(bricks, other) == k_none) return k_none;
  }
  return brick;
}

void put_in(SkinSand* sand, SkinBricks* bricks, uint32_t number) {
  SkinParticle& p = sand->particles[number];
  int32_t cell[3], at[3];
  cell_of(p, cell, at);
  const uint32_t brick = make_room(bricks, cell, at);
  if (brick == k_none) {
    p.share = 0;
    ++sand->left_out;
    return;
  }
  spread(bricks, brick, p, 1);
  ++bricks->records[brick].touches;
  uint32_t& first = bricks->nodes[brick].particles[node_of(cell)];
  p.last = k_none;
  p.next = first;
  if (first != k_none) sand->particles[first].last = number;
  first = number;
}

uint8_t share_of(float falls) {
  const float t = (falls - k_falls_from) * (1.0f / k_falls_over);
  if (!(t > 0)) return k_skin_shares;
  if (t >= 1) return 0;
  return static_cast<uint8_t>(to_whole<uint32_t>(k_skin_shares * (1.0f - t * t * (3.0f - 2.0f * t)) + 0.5f));
}

// Whether what was taken is of this moment.
bool is_of_now(const SkinSand& sand, const SkinState& s) {
  return sand.frame == s.frame && sand.substeps == s.granular->counts.moments();
}

bool is_near(const int32_t a[3], const int32_t b[3]) {
  for (uint32_t k = 0; k < 3; ++k)
    if (a[k] - b[k] > k_skin_held || b[k] - a[k] > k_skin_held) return false;
  return true;
}

}  // namespace

// Sand in a bucket that is lowered lies as still as on the floor. Below sand is what its box, drawn out upward, holds
// it.
void skin_find_fall(const SkinState& s, const float position[3], const float velocity[3], float* falls, bool* flies) {
  float best[3] = {velocity[0], velocity[1], velocity[2]};
  float slowest = best[0] * best[0] + best[1] * best[1] + best[2] * best[2];
  for (uint32_t m = 0; m < s.solids.mover_count && slowest > k_flies * k_flies; ++m) {
    const ColliderFrame& c = s.solids.colliders[s.solids.movers[m]];
    float d[3];
    bool over = true;
    for (uint32_t a = 0; a < 3; ++a) {
      const uint32_t w = s.lattice.axis[a];
      d[w] = position[w] - c.position[w];
      const float beyond = a == 1 ? -s.lattice.sign[1] * d[w] : __builtin_fabsf(d[w]);
      over = over && (c.shape == SANDGLASS_SHAPE_HALF_SPACE || beyond <= c.extent[w]);
    }
    if (!over) continue;
    const float* t = c.angular;
    const float rest[3] = {velocity[0] - (c.linear[0] + (t[1] * d[2] - t[2] * d[1])),
                           velocity[1] - (c.linear[1] + (t[2] * d[0] - t[0] * d[2])),
                           velocity[2] - (c.linear[2] + (t[0] * d[1] - t[1] * d[0]))};
    const float square = rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2];
    if (square < slowest) {
      slowest = square;
      memcpy(best, rest, sizeof best);
    }
  }
  *flies = slowest > k_flies * k_flies;
  *falls = 0;
  for (uint32_t a = 0; a < 3; ++a) *falls -= s.lattice.up[a] * s.lattice.sign[a] * best[s.lattice.axis[a]];
}

// A taken particle costs a quarter of a gathered one.
uint32_t skin_take_items(const SkinState& s) {
  const uint32_t count = s.granular->particles.count;
  return 1 + (count < k_unit_taken ? count : k_unit_taken) / 4;
}

void sand_begin_cycle(SkinSand* sand, uint32_t capacity) {
  ++sand->cycle;
  sand->left_out = sand->restarts = 0;
  sand->next_record = sand->next_taken = sand->next_number = 0;
  for (uint32_t i = 0; i < capacity; ++i) sand->from[3 * i] = k_skin_nowhere;
}

void sand_forget(SkinSand* sand, uint32_t capacity) {
  for (uint32_t i = 0; i < capacity; ++i) sand->particles[i] = {};
  sand->numbers = 0;
}

// Particles that moved on meanwhile are taken from the start, so that all are of one moment; not for ever.
bool sand_begins(SkinSand* sand, const SkinState& s) {
  constexpr uint32_t k_restarts = 3;
  if (sand->next_record != 0 && !is_of_now(*sand, s) && sand->restarts < k_restarts) {
    ++sand->restarts;
    sand->next_record = 0;
  }
  if (sand->next_record != 0) return false;
  sand->frame = s.frame;
  sand->substeps = s.granular->counts.moments();
  sand->taken_count = 0;
  sand->next_taken = 0;
  return true;
}

bool skin_take(SkinSand* sand, const SkinState& s) {
  const Particles& particles = s.granular->particles;
  const uint32_t left = particles.count - (sand->next_record < particles.count ? sand->next_record : particles.count);
  const uint32_t end = sand->next_record + (left < k_unit_taken ? left : k_unit_taken);
  for (; sand->next_record < end; ++sand->next_record) {
    const Particle& record = particles.records[0][sand->next_record];
    if (in_body(record) || has_departed(record) || sand->taken_count == s.desc.particle_capacity) continue;
    SkinTaken& taken = sand->taken[sand->taken_count++];
    memcpy(taken.position, record.position, sizeof taken.position);
    memcpy(taken.velocity, record.velocity, sizeof taken.velocity);
    taken.number = number_of(record);
    float falls;
    skin_find_fall(s, taken.position, taken.velocity, &falls, &taken.flies);
    taken.share = share_of(falls);
  }
  if (sand->next_record < particles.count) return false;
  sand->missing = !is_of_now(*sand, s);
  sand->next_record = 0;
  return true;
}

bool skin_gather_moved(SkinSand* sand, SkinBricks* bricks, const SkinState& s) {
  const uint32_t left = sand->taken_count - sand->next_taken;
  const uint32_t end = sand->next_taken + (left < k_skin_unit_items ? left : k_skin_unit_items);
  for (; sand->next_taken < end; ++sand->next_taken) {
    const SkinTaken& taken = sand->taken[sand->next_taken];
    const uint32_t number = taken.number;
    if (number >= s.desc.particle_capacity) {
      ++sand->left_out;
      continue;
    }
    SkinParticle& p = sand->particles[number];
    SkinParticle now = {};
    lattice_place(s.lattice, taken.position, now.at);
    now.share = taken.share;
    p.seen = sand->cycle;
    memcpy(sand->from + 3 * number, taken.position, sizeof taken.position);
    if (number >= sand->numbers) sand->numbers = number + 1;
    if (p.share == now.share && (now.share == 0 || is_near(p.at, now.at))) continue;
    take_out(sand, bricks, number);
    memcpy(p.at, now.at, sizeof p.at);
    p.share = now.share;
    p.moved = sand->cycle;
    if (p.share != 0) put_in(sand, bricks, number);
  }
  return sand->next_taken == sand->taken_count;
}

bool skin_gather_gone(SkinSand* sand, SkinBricks* bricks) {
  // While particles are taken they may be sorted, and one be missed; not twice in a row.
  const uint8_t missed = sand->missing ? 2 : 1;
  const uint32_t left = sand->numbers - sand->next_number, limit = 4 * k_skin_unit_items;
  const uint32_t end = sand->next_number + (left < limit ? left : limit);
  for (; sand->next_number < end; ++sand->next_number) {
    const SkinParticle& p = sand->particles[sand->next_number];
    if (p.share != 0 && static_cast<uint8_t>(sand->cycle - p.seen) >= missed) take_out(sand, bricks, sand->next_number);
  }
  return sand->next_number == sand->numbers;
}

}  // namespace sandglass
