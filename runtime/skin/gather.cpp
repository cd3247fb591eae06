// Sand and colliders are taken at one moment: a skin may need more than a frame, and sand goes on with what holds it.
//
// What of the sand has moved: it is taken out of the sums where it was, and put in where it is. A particle is spread over
// the eight nodes about it, in whole numbers, so that what was put in can be taken out again exactly.
//
// What falls is no part of the surface: a particle counts less the faster it comes down to what is below it.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_falls_from = 0.5f, k_falls_over = 0.3f, k_flies = 0.35f;  // m/s

// Adds a particle's share to the sums, or takes it away (sign -1).
void spread(SkinState* s, uint32_t number, const SkinParticle& p, uint32_t sign) {
  int32_t cell[3];
  uint32_t far[3], local[3];
  for (uint32_t a = 0; a < 3; ++a) {
    cell[a] = p.at[a] >> 7;
    far[a] = static_cast<uint32_t>(p.at[a] & (k_skin_steps - 1));
    local[a] = static_cast<uint32_t>(cell[a] & 7);
  }
  constexpr uint32_t k_round = 9;  // 128^3 becomes k_skin_one
  const uint32_t share = sign * p.share;
  const uint32_t wx[2] = {k_skin_steps - far[0], far[0]}, wy[2] = {k_skin_steps - far[1], far[1]};
  const uint32_t wz[2] = {k_skin_steps - far[2], far[2]};
  const Brick& own = s->bricks[number];
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t x = local[0] + (c & 1), z = local[2] + (c >> 1 & 1), y = local[1] + (c >> 2);
    const uint32_t brick = own.around[k_brick_itself + (x >> 3) + 3 * (z >> 3) + 9 * (y >> 3)];
    s->nodes[brick].sums[(x & 7) + k_brick_side * (z & 7) + k_brick_layer * (y & 7)] +=
        (wx[c & 1] * wy[c >> 2] * wz[c >> 1 & 1] >> k_round) * share;
  }
  // The density of the nodes beside those changes, too.
  const uint32_t x0 = local[0] == 0 ? 0 : 1, x1 = local[0] >= 6 ? 2 : 1, y0 = local[1] == 0 ? 0 : 1,
                 y1 = local[1] >= 6 ? 2 : 1;
  const uint32_t z0 = local[2] == 0 ? 0 : 1, z1 = local[2] >= 6 ? 2 : 1;
  for (uint32_t y = y0; y <= y1; ++y)
    for (uint32_t z = z0; z <= z1; ++z)
      for (uint32_t x = x0; x <= x1; ++x) {
        const uint32_t brick = own.around[x + 3 * z + 9 * y];
        if (brick != k_brick_none) s->bricks[brick].stale |= k_stale_density | k_stale_mesh;
      }
}

void cell_of(const SkinParticle& p, int32_t cell[3], int32_t at[3]) {
  for (uint32_t a = 0; a < 3; ++a) {
    cell[a] = p.at[a] >> 7;
    at[a] = cell[a] >> 3;
  }
}

void take_out(SkinState* s, uint32_t number) {
  SkinParticle& p = s->particles[number];
  if (p.share == 0) return;
  int32_t cell[3], at[3];
  cell_of(p, cell, at);
  const uint32_t brick = brick_find(*s, at);
  spread(s, brick, p, ~0u);
  --s->bricks[brick].touches;
  if (p.next != k_brick_none) s->particles[p.next].last = p.last;
  if (p.last != k_brick_none) s->particles[p.last].next = p.next;
  else s->nodes[brick].particles[node_of(cell)] = p.next;
  p.share = 0;
  p.moved = s->cycle;
}

// The bricks of the eight nodes about a cell, made where they are not there. k_brick_none: there is no room for all.
uint32_t make_room(SkinState* s, const int32_t cell[3], const int32_t at[3]) {
  const uint32_t brick = brick_make(s, at);
  if (brick == k_brick_none) return brick;
  for (uint32_t c = 1; c < 8; ++c) {
    const bool x = (c & 1) != 0, z = (c & 2) != 0, y = (c & 4) != 0;
    if ((x && (cell[0] & 7) != 7) || (z && (cell[2] & 7) != 7) || (y && (cell[1] & 7) != 7)) continue;
    if (s->bricks[brick].around[k_brick_itself + (x ? 1 : 0) + (z ? 3 : 0) + (y ? 9 : 0)] != k_brick_none) continue;
    const int32_t other[3] = {at[0] + (x ? 1 : 0), at[1] + (y ? 1 : 0), at[2] + (z ? 1 : 0)};
    if (brick_make(s, other) == k_brick_none) return k_brick_none;
  }
  return brick;
}

void put_in(SkinState* s, uint32_t number) {
  SkinParticle& p = s->particles[number];
  int32_t cell[3], at[3];
  cell_of(p, cell, at);
  const uint32_t brick = make_room(s, cell, at);
  if (brick == k_brick_none) {
    p.share = 0;
    ++s->left_out_now;
    return;
  }
  spread(s, brick, p, 1);
  ++s->bricks[brick].touches;
  uint32_t& first = s->nodes[brick].particles[node_of(cell)];
  p.last = k_brick_none;
  p.next = first;
  if (first != k_brick_none) s->particles[first].last = number;
  first = number;
}

uint8_t share_of(float falls) {
  const float t = (falls - k_falls_from) * (1.0f / k_falls_over);
  if (!(t > 0)) return k_skin_shares;
  if (t >= 1) return 0;
  return static_cast<uint8_t>(to_whole<uint32_t>(k_skin_shares * (1.0f - t * t * (3.0f - 2.0f * t)) + 0.5f));
}

bool is_near(const int32_t a[3], const int32_t b[3]) {
  for (uint32_t k = 0; k < 3; ++k)
    if (a[k] - b[k] > k_skin_held || b[k] - a[k] > k_skin_held) return false;
  return true;
}

}  // namespace

// Sand in a bucket that is lowered lies as still as on the floor. Below sand is what its box, drawn out upward, holds it.
void skin_find_fall(const SkinState& s, const float position[3], const float velocity[3], float* falls, bool* flies) {
  float best[3] = {velocity[0], velocity[1], velocity[2]};
  float least = best[0] * best[0] + best[1] * best[1] + best[2] * best[2];
  for (uint32_t m = 0; m < s.mover_count && least > k_flies * k_flies; ++m) {
    const ColliderFrame& c = s.colliders[s.movers[m]];
    float d[3];
    bool over = true;
    for (uint32_t a = 0; a < 3; ++a) {
      const uint32_t w = s.axis[a];
      d[w] = position[w] - c.position[w];
      const float beyond = a == 1 ? -s.sign[1] * d[w] : __builtin_fabsf(d[w]);
      over = over && (c.shape == SANDGLASS_SHAPE_HALF_SPACE || beyond <= c.extent[w]);
    }
    if (!over) continue;
    const float* t = c.angular;
    const float rest[3] = {velocity[0] - (c.linear[0] + (t[1] * d[2] - t[2] * d[1])),
                           velocity[1] - (c.linear[1] + (t[2] * d[0] - t[0] * d[2])),
                           velocity[2] - (c.linear[2] + (t[0] * d[1] - t[1] * d[0]))};
    const float square = rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2];
    if (square < least) {
      least = square;
      memcpy(best, rest, sizeof best);
    }
  }
  *flies = least > k_flies * k_flies;
  *falls = 0;
  for (uint32_t a = 0; a < 3; ++a) *falls -= s.up[a] * s.sign[a] * best[s.axis[a]];
}

// A taken particle costs a quarter of a gathered one.
uint32_t skin_take_items(const SkinState& s) {
  const uint32_t count = s.granular->particles.count;
  return 1 + (count < k_skin_unit_taken ? count : k_skin_unit_taken) / 4;
}

// Particles that moved on meanwhile are taken from the start, so that all are of one moment; not for ever.
bool skin_take(SkinState* s) {
  constexpr uint32_t k_restarts = 3;
  const Particles& particles = s->granular->particles;
  const uint32_t substeps = s->granular->counts.moments();
  if (s->cursor != 0 && (s->gathered_frame != s->frame || s->gathered_substeps != substeps) &&
      s->restarts < k_restarts) {
    ++s->restarts;
    s->cursor = 0;
  }
  if (s->cursor == 0) {
    s->gathered_frame = s->frame;
    s->gathered_substeps = substeps;
    s->taken_count = 0;
    skin_take_colliders(s, colliders_behind(*s->granular));
    for (uint32_t b = 0; b < s->brick_count; ++b)
      if ((s->bricks[b].stale & k_stale_solid) != 0) s->bricks[b].stale |= k_stale_density;
  }
  const uint32_t most = particles.count - (s->cursor < particles.count ? s->cursor : particles.count);
  const uint32_t end = s->cursor + (most < k_skin_unit_taken ? most : k_skin_unit_taken);
  for (; s->cursor < end; ++s->cursor) {
    const Particle& record = particles.records[0][s->cursor];
    if (in_body(record) || has_departed(record) || s->taken_count == s->desc.particle_capacity) continue;
    SkinTaken& taken = s->taken[s->taken_count++];
    memcpy(taken.position, record.position, sizeof taken.position);
    memcpy(taken.velocity, record.velocity, sizeof taken.velocity);
    taken.number = number_of(record);
    float falls;
    skin_find_fall(*s, taken.position, taken.velocity, &falls, &taken.flies);
    taken.share = share_of(falls);
  }
  if (s->cursor < particles.count) return false;
  s->missing = s->gathered_frame != s->frame || s->gathered_substeps != substeps;
  s->cursor = 0;
  return true;
}

bool skin_gather(SkinState* s) {
  const uint32_t most = s->taken_count - s->cursor;
  const uint32_t end = s->cursor + (most < k_skin_unit_items ? most : k_skin_unit_items);
  for (; s->cursor < end; ++s->cursor) {
    const SkinTaken& taken = s->taken[s->cursor];
    const uint32_t number = taken.number;
    if (number >= s->desc.particle_capacity) {
      ++s->left_out_now;
      continue;
    }
    SkinParticle& p = s->particles[number];
    SkinParticle now = {};
    skin_place(*s, taken.position, now.at);
    now.share = taken.share;
    p.seen = s->cycle;
    memcpy(s->back.from + 3 * number, taken.position, sizeof taken.position);
    if (number >= s->particle_numbers) s->particle_numbers = number + 1;
    if (p.share == now.share && (now.share == 0 || is_near(p.at, now.at))) continue;
    take_out(s, number);
    memcpy(p.at, now.at, sizeof p.at);
    p.share = now.share;
    p.moved = s->cycle;
    if (p.share != 0) put_in(s, number);
  }
  if (s->cursor < s->taken_count) return false;
  s->cursor = 0;
  return true;
}

bool skin_leave(SkinState* s) {
  // While particles are taken they may be sorted, and one be missed; not twice in a row.
  const uint8_t missed = s->missing ? 2 : 1;
  const uint32_t left = s->particle_numbers - s->cursor, most = 4 * k_skin_unit_items;
  const uint32_t end = s->cursor + (left < most ? left : most);
  for (; s->cursor < end; ++s->cursor)
    if (s->particles[s->cursor].share != 0 && static_cast<uint8_t>(s->cycle - s->particles[s->cursor].seen) >= missed)
      take_out(s, s->cursor);
  if (s->cursor < s->particle_numbers) return false;
  s->cursor = 0;
  return true;
}

}  // namespace sandglass
