// The bricks of the lattice, in an open hash table, each knowing those around it; and the chunks that they lie in.
#include <cstring>

#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

uint32_t slot_of(const SkinState& s, const int32_t at[3]) { return motion_hash(at[0], at[1], at[2]) & s.slot_mask; }

bool same_place(const int32_t a[3], const int32_t b[3]) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

bool comes_before(const int32_t a[3], const int32_t b[3]) {
  if (a[0] != b[0]) return a[0] < b[0];
  return a[1] != b[1] ? a[1] < b[1] : a[2] < b[2];
}

// The chunk of a brick, one brick more in it. k_brick_none: there is no room.
uint32_t join_chunk(SkinState* s, const int32_t brick[3]) {
  int32_t at[3];
  for (uint32_t a = 0; a < 3; ++a) at[a] = brick[a] >> 2;
  uint32_t free = k_brick_none;
  for (uint32_t c = 0; c < s->chunk_capacity; ++c) {
    SkinChunk& chunk = s->chunks[c];
    if (chunk.bricks == 0) {
      if (free == k_brick_none) free = c;
    } else if (same_place(chunk.at, at)) {
      ++chunk.bricks;
      return c;
    }
  }
  if (free == k_brick_none) return free;
  SkinChunk& chunk = s->chunks[free];
  memcpy(chunk.at, at, sizeof chunk.at);
  chunk.bricks = 1;
  uint32_t place = s->chunk_count++;
  for (; place > 0 && comes_before(at, s->chunks[s->chunk_order[place - 1]].at); --place)
    s->chunk_order[place] = s->chunk_order[place - 1];
  s->chunk_order[place] = free;
  return free;
}

void leave_chunk(SkinState* s, uint32_t chunk) {
  if (--s->chunks[chunk].bricks != 0) return;
  uint32_t place = 0;
  while (s->chunk_order[place] != chunk) ++place;
  for (--s->chunk_count; place < s->chunk_count; ++place) s->chunk_order[place] = s->chunk_order[place + 1];
}

}  // namespace

void brick_beside(const int32_t at[3], uint32_t k, int32_t other[3]) {
  other[0] = at[0] + static_cast<int32_t>(k % 3) - 1;
  other[1] = at[1] + static_cast<int32_t>(k / 9) - 1;
  other[2] = at[2] + static_cast<int32_t>(k / 3 % 3) - 1;
}

uint32_t brick_find(const SkinState& s, const int32_t at[3]) {
  for (uint32_t slot = slot_of(s, at); s.slots[slot] != 0; slot = (slot + 1) & s.slot_mask)
    if (same_place(s.bricks[s.slots[slot] - 1].at, at)) return s.slots[slot] - 1;
  return k_brick_none;
}

uint32_t brick_make(SkinState* s, const int32_t at[3]) {
  const uint32_t found = brick_find(*s, at);
  if (found != k_brick_none) return found;
  if (s->free_count == 0 && s->brick_count == s->brick_capacity) return k_brick_none;
  const uint32_t chunk = join_chunk(s, at);
  if (chunk == k_brick_none) return k_brick_none;
  const uint32_t number = s->free_count != 0 ? s->free_bricks[--s->free_count] : s->brick_count++;
  Brick& brick = s->bricks[number];
  brick = {};
  memcpy(brick.at, at, sizeof brick.at);
  brick.used = true;
  brick.chunk = chunk;
  brick.stale = k_stale_solid | k_stale_density | k_stale_fill | k_stale_calm | k_stale_mesh;
  BrickNodes& nodes = s->nodes[number];
  memset(&nodes, 0, sizeof nodes);
  memset(nodes.particles, 0xff, sizeof nodes.particles);
  memset(nodes.vertices, 0xff, sizeof nodes.vertices);
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    int32_t other[3];
    brick_beside(at, k, other);
    brick.around[k] = k == k_brick_itself ? number : brick_find(*s, other);
    if (brick.around[k] != k_brick_none) s->bricks[brick.around[k]].around[k_bricks_around - 1 - k] = number;
    if (brick.around[k] != k_brick_none) s->bricks[brick.around[k]].room_known = false;
  }
  uint32_t slot = slot_of(*s, at);
  while (s->slots[slot] != 0) slot = (slot + 1) & s->slot_mask;
  s->slots[slot] = number + 1;
  return number;
}

void brick_release(SkinState* s, uint32_t number) {
  Brick& brick = s->bricks[number];
  for (uint32_t k = 0; k < k_bricks_around; ++k)
    if (brick.around[k] != k_brick_none) s->bricks[brick.around[k]].around[k_bricks_around - 1 - k] = k_brick_none;
  uint32_t gap = slot_of(*s, brick.at);
  while (s->slots[gap] != number + 1) gap = (gap + 1) & s->slot_mask;
  // What comes after the gap and would not be found beyond it moves into it.
  for (uint32_t slot = (gap + 1) & s->slot_mask; s->slots[slot] != 0; slot = (slot + 1) & s->slot_mask) {
    const uint32_t home = slot_of(*s, s->bricks[s->slots[slot] - 1].at);
    if (((slot - home) & s->slot_mask) < ((slot - gap) & s->slot_mask)) continue;
    s->slots[gap] = s->slots[slot];
    gap = slot;
  }
  s->slots[gap] = 0;
  leave_chunk(s, brick.chunk);
  brick.used = false;
  s->free_bricks[s->free_count++] = number;
}

void skin_forget(SkinState* s) {
  memset(s->slots, 0, (uint64_t{s->slot_mask} + 1) * sizeof(uint32_t));
  for (uint32_t c = 0; c < s->chunk_capacity; ++c) s->chunks[c].bricks = 0;
  s->brick_count = s->free_count = s->chunk_count = 0;
  for (uint32_t i = 0; i < s->desc.particle_capacity; ++i) s->particles[i] = {};
  s->particle_numbers = 0;
  s->phase = SkinPhase::idle;
}

}  // namespace sandglass
