// What of the sand is not in the mesh: what flies, and what lies in too thin a density. And the end of a skin: bricks
// that nothing needs any more are released, and the two meshes change places.
#include <cstring>

#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_weight_min = 0.04f;
// Shares of the level. At a density below k_thin nothing of a particle is in the mesh, above k_thick all of it; of one
// that flies, above k_thick_flying.
constexpr float k_thin = 0.45f, k_thick = 1.2f, k_thick_flying = 0.6f;

// The density at the corners of a cell. False: there is none. `brick`: that of the particle before, then of this one.
bool density_about(const SkinBricks& bricks, const int32_t cell[3], uint32_t* brick, CellValues* values) {
  const int32_t at[3] = {brick_along(cell[0]), brick_along(cell[1]), brick_along(cell[2])};
  if (*brick == k_none || memcmp(at, bricks.records[*brick].at, sizeof at) != 0) *brick = brick_find(bricks, at);
  const uint32_t number = *brick, x = node_along(cell[0]), y = node_along(cell[1]), z = node_along(cell[2]);
  constexpr uint32_t k_last = k_brick_side - 1;
  if (number == k_none) return false;
  if (x != k_last && y != k_last && z != k_last) {
    *values = CellValues(bricks.nodes[number].calm + node_of(cell), k_node_step);
    return true;
  }
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t i = x + (c & 1), j = y + (c >> 1 & 1), k = z + (c >> 2);
    const uint32_t other = bricks.records[number].around[brick_around(i, j, k)];
    const uint32_t node = node_index(node_along(i), node_along(j), node_along(k));
    values->v[c] = other == k_none ? 0.0f : static_cast<float>(bricks.nodes[other].calm[node]);
  }
  return true;
}

// False: all of it is in the mesh.
bool loose_of(const SkinState& s, const SkinTaken& p, uint32_t* brick, sandglass_skin_loose* out) {
  const float low = k_thin * k_skin_level, high = (p.flies ? k_thick_flying : k_thick) * k_skin_level;
  int32_t place[3], cell[3];
  float u[3], gradient[3] = {0, 0, 0};
  CellValues density;
  lattice_place(s.lattice, p.position, place);
  for (uint32_t a = 0; a < 3; ++a) {
    cell[a] = place[a] >> k_skin_step_shift;
    u[a] = static_cast<float>(place[a] & (k_skin_steps - 1)) * (1.0f / k_skin_steps);
  }
  const bool any = density_about(s.bricks, cell, brick, &density);
  bool buried = any;
  for (const float corner : density.v) buried = buried && corner >= high;
  if (buried) return false;
  const float t = any ? (density.at(u) - low) / (high - low) : 0.0f;
  const float weight = t < 0 ? 1.0f : t < 1 ? 1.0f - t * t * (3.0f - 2.0f * t) : 0.0f;
  if (weight < k_weight_min) return false;
  if (any) density.gradient(u, gradient);
  *out = {};
  memcpy(out->position, p.position, sizeof out->position);
  out->weight = weight;
  out->number = p.number;
  if (p.flies) {
    memcpy(out->vector, p.velocity, sizeof out->vector);
    return true;
  }
  // Away from the sand about it, and upward where there is little.
  const float square = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
  const float scale = square > 1.0f ? (1.0f - weight) / __builtin_sqrtf(square) : 0.0f;
  float direction[3], length = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    direction[a] = weight * s.lattice.up[a] - scale * gradient[a];
    length += direction[a] * direction[a];
  }
  const float inverse = length > 1e-6f ? 1.0f / __builtin_sqrtf(length) : 0.0f;
  for (uint32_t a = 0; a < 3; ++a)
    out->vector[s.lattice.axis[a]] = s.lattice.sign[a] * (inverse != 0.0f ? inverse * direction[a] : s.lattice.up[a]);
  return true;
}

bool is_needed(const SkinBricks& bricks, const Brick& brick) {
  if (brick.count != 0 || brick.calm) return true;
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    const uint32_t other = brick.around[k];
    if (other == k_none) continue;
    if (bricks.records[other].touches != 0 || (bricks.records[other].wants >> seen_from(k) & 1) != 0) return true;
  }
  return false;
}

// The mesh is made: no brick counts as changed. Releases bricks that nothing needs.
void settle_bricks(SkinBricks* bricks) {
  for (uint32_t b = 0; b < bricks->count; ++b) {
    Brick& brick = bricks->records[b];
    if (!brick.used) continue;
    if ((brick.stale & k_stale_mesh) != 0) memset(bricks->nodes[b].changed, 0, sizeof bricks->nodes[b].changed);
    brick.stale &= ~k_stale_mesh;
    if (!is_needed(*bricks, brick)) brick_release(bricks, b);
  }
}

}  // namespace

void skin_begin_loose(SkinMeshes* meshes) {
  meshes->back.flying = meshes->back.lying = 0;
  meshes->next_loose = 0;
}

// Those that fly are written from the front of the list on, those that lie from its end on.
bool skin_loose(SkinMeshes* meshes, SkinBricks* bricks, const SkinState& s) {
  SkinMesh& back = meshes->back;
  const uint32_t capacity = s.desc.particle_capacity, left = s.sand.taken_count - meshes->next_loose;
  const uint32_t end = meshes->next_loose + (left < k_skin_unit_items ? left : k_skin_unit_items);
  uint32_t last = k_none;
  for (; meshes->next_loose < end; ++meshes->next_loose) {
    const SkinTaken& p = s.sand.taken[meshes->next_loose];
    sandglass_skin_loose loose;
    if (!loose_of(s, p, &last, &loose)) continue;
    back.loose[p.flies ? back.flying++ : capacity - ++back.lying] = loose;
  }
  if (meshes->next_loose < s.sand.taken_count) return false;
  memmove(back.loose + back.flying, back.loose + capacity - back.lying, back.lying * sizeof *back.loose);
  settle_bricks(bricks);
  return true;
}

}  // namespace sandglass
