// The bricks of the lattice, in an open hash table, each knowing those around it; and the chunks that they lie in.
#include <cstring>

#include "kernels/kernels.h"
#include "runtime/skin/bricks.h"

namespace sandglass {
namespace {

uint32_t slot_of(const SkinBricks& bricks, const int32_t at[3]) {
  return motion_hash(at[0], at[1], at[2]) & bricks.slot_mask;
}

bool same_place(const int32_t a[3], const int32_t b[3]) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

bool comes_before(const int32_t a[3], const int32_t b[3]) {
  if (a[0] != b[0]) return a[0] < b[0];
  return a[1] != b[1] ? a[1] < b[1] : a[2] < b[2];
}

// The chunk of a brick, one brick more in it. k_none: there is no room.
uint32_t join_chunk(SkinChunks* chunks, const int32_t brick[3]) {
  int32_t at[3];
  for (uint32_t a = 0; a < 3; ++a) at[a] = brick[a] >> k_chunk_shift;
  uint32_t free = k_none;
  for (uint32_t c = 0; c < chunks->capacity; ++c) {
    SkinChunk& chunk = chunks->records[c];
    if (chunk.bricks == 0) {
      if (free == k_none) free = c;
    } else if (same_place(chunk.at, at)) {
      ++chunk.bricks;
      return c;
    }
  }
  if (free == k_none) return free;
  SkinChunk& chunk = chunks->records[free];
  memcpy(chunk.at, at, sizeof chunk.at);
  chunk.bricks = 1;
  uint32_t place = chunks->count++;
  for (; place > 0 && comes_before(at, chunks->records[chunks->order[place - 1]].at); --place)
    chunks->order[place] = chunks->order[place - 1];
  chunks->order[place] = free;
  return free;
}

void leave_chunk(SkinChunks* chunks, uint32_t chunk) {
  if (--chunks->records[chunk].bricks != 0) return;
  uint32_t place = 0;
  while (chunks->order[place] != chunk) ++place;
  for (--chunks->count; place < chunks->count; ++place) chunks->order[place] = chunks->order[place + 1];
}

}  // namespace

void brick_beside(const int32_t at[3], uint32_t k, int32_t other[3]) {
  other[0] = at[0] + static_cast<int32_t>(around_x(k)) - 1;
  other[1] = at[1] + static_cast<int32_t>(around_y(k)) - 1;
  other[2] = at[2] + static_cast<int32_t>(around_z(k)) - 1;
}

uint32_t brick_find(const SkinBricks& bricks, const int32_t at[3]) {
  for (uint32_t slot = slot_of(bricks, at); bricks.slots[slot] != 0; slot = (slot + 1) & bricks.slot_mask)
    if (same_place(bricks.records[bricks.slots[slot] - 1].at, at)) return bricks.slots[slot] - 1;
  return k_none;
}

uint32_t brick_make(SkinBricks* bricks, const int32_t at[3]) {
  const uint32_t found = brick_find(*bricks, at);
  if (found != k_none) return found;
  if (bricks->free_count == 0 && bricks->count == bricks->capacity) return k_none;
  const uint32_t chunk = join_chunk(&bricks->chunks, at);
  if (chunk == k_none) return k_none;
  const uint32_t number = bricks->free_count != 0 ? bricks->free[--bricks->free_count] : bricks->count++;
  Brick& brick = bricks->records[number];
  brick = {};
  memcpy(brick.at, at, sizeof brick.at);
  brick.used = true;
  brick.chunk = chunk;
  brick.stale = k_stale_solid | k_stale_density | k_stale_fill | k_stale_calm | k_stale_mesh;
  BrickNodes& nodes = bricks->nodes[number];
  memset(&nodes, 0, sizeof nodes);
  memset(nodes.particles, 0xff, sizeof nodes.particles);
  memset(nodes.vertices, 0xff, sizeof nodes.vertices);
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    int32_t other[3];
    brick_beside(at, k, other);
    brick.around[k] = k == k_brick_itself ? number : brick_find(*bricks, other);
    if (brick.around[k] != k_none) bricks->records[brick.around[k]].around[seen_from(k)] = number;
    if (brick.around[k] != k_none) bricks->records[brick.around[k]].room_known = false;
  }
  uint32_t slot = slot_of(*bricks, at);
  while (bricks->slots[slot] != 0) slot = (slot + 1) & bricks->slot_mask;
  bricks->slots[slot] = number + 1;
  return number;
}

void brick_release(SkinBricks* bricks, uint32_t number) {
  Brick& brick = bricks->records[number];
  for (uint32_t k = 0; k < k_bricks_around; ++k)
    if (brick.around[k] != k_none) bricks->records[brick.around[k]].around[seen_from(k)] = k_none;
  uint32_t gap = slot_of(*bricks, brick.at);
  while (bricks->slots[gap] != number + 1) gap = (gap + 1) & bricks->slot_mask;
  // What comes after the gap and would not be found beyond it moves into it.
  for (uint32_t slot = (gap + 1) & bricks->slot_mask; bricks->slots[slot] != 0; slot = (slot + 1) & bricks->slot_mask) {
    const uint32_t home = slot_of(*bricks, bricks->records[bricks->slots[slot] - 1].at);
    if (((slot - home) & bricks->slot_mask) < ((slot - gap) & bricks->slot_mask)) continue;
    bricks->slots[gap] = bricks->slots[slot];
    gap = slot;
  }
  bricks->slots[gap] = 0;
  leave_chunk(&bricks->chunks, brick.chunk);
  brick.used = false;
  bricks->free[bricks->free_count++] = number;
}

void bricks_forget(SkinBricks* bricks) {
  memset(bricks->slots, 0, (uint64_t{bricks->slot_mask} + 1) * sizeof(uint32_t));
  for (uint32_t c = 0; c < bricks->chunks.capacity; ++c) bricks->chunks.records[c].bricks = 0;
  bricks->count = bricks->free_count = bricks->chunks.count = 0;
}

}  // namespace sandglass
