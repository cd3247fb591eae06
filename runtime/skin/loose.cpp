// What of the sand is not in the mesh: what flies, and what lies in too thin a density. And the end of a skin: bricks that
// nothing needs any more are released, and the two meshes change places.
#include <cstring>

#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_least_weight = 0.04f;
// Of the level: none of it is in the mesh, all of it is. What moves lies in a thinner density.
constexpr float k_thin = 0.45f, k_thick = 1.2f, k_thick_flying = 0.6f;

// The density at the corners of a cell. False: there is none. `brick`: that of the particle before, then of this one.
bool density_about(const SkinState& s, const int32_t cell[3], uint32_t* brick, CellValues* values) {
  const int32_t at[3] = {cell[0] >> 3, cell[1] >> 3, cell[2] >> 3};
  if (*brick == k_brick_none || memcmp(at, s.bricks[*brick].at, sizeof at) != 0) *brick = brick_find(s, at);
  const uint32_t number = *brick, x = static_cast<uint32_t>(cell[0] & 7);
  const uint32_t y = static_cast<uint32_t>(cell[1] & 7), z = static_cast<uint32_t>(cell[2] & 7);
  if (number == k_brick_none) return false;
  if (x != 7 && y != 7 && z != 7) {
    constexpr uint32_t k_steps[3] = {1, k_brick_layer, k_brick_side};
    *values = CellValues(s.nodes[number].calm + node_of(cell), k_steps);
    return true;
  }
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t i = x + (c & 1), j = y + (c >> 1 & 1), k = z + (c >> 2);
    const uint32_t other = s.bricks[number].around[k_brick_itself + (i >> 3) + 3 * (k >> 3) + 9 * (j >> 3)];
    values->v[c] =
        other == k_brick_none ? 0.0f : static_cast<float>(s.nodes[other].calm[(i & 7) + 8 * (k & 7) + 64 * (j & 7)]);
  }
  return true;
}

// False: all of it is in the mesh.
bool loose_of(const SkinState& s, const SkinTaken& p, uint32_t* brick, sandglass_skin_loose* out) {
  const float least = k_thin * k_skin_level, most = (p.flies ? k_thick_flying : k_thick) * k_skin_level;
  int32_t place[3], cell[3];
  float u[3], gradient[3] = {0, 0, 0};
  CellValues density;
  skin_place(s, p.position, place);
  for (uint32_t a = 0; a < 3; ++a) {
    cell[a] = place[a] >> 7;
    u[a] = static_cast<float>(place[a] & (k_skin_steps - 1)) * (1.0f / k_skin_steps);
  }
  const bool any = density_about(s, cell, brick, &density);
  bool buried = any;
  for (const float corner : density.v) buried = buried && corner >= most;
  if (buried) return false;
  const float t = any ? (density.at(u) - least) / (most - least) : 0.0f;
  const float weight = t < 0 ? 1.0f : t < 1 ? 1.0f - t * t * (3.0f - 2.0f * t) : 0.0f;
  if (weight < k_least_weight) return false;
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
  float way[3], length = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    way[a] = weight * s.up[a] - scale * gradient[a];
    length += way[a] * way[a];
  }
  const float inverse = length > 1e-6f ? 1.0f / __builtin_sqrtf(length) : 0.0f;
  for (uint32_t a = 0; a < 3; ++a) out->vector[s.axis[a]] = s.sign[a] * (inverse != 0.0f ? inverse * way[a] : s.up[a]);
  return true;
}

bool is_needed(const SkinState& s, const Brick& brick) {
  if (brick.count != 0 || brick.calm) return true;
  for (uint32_t k = 0; k < k_bricks_around; ++k) {
    const uint32_t other = brick.around[k];
    if (other == k_brick_none) continue;
    if (s.bricks[other].touches != 0 || (s.bricks[other].wants >> (k_bricks_around - 1 - k) & 1) != 0) return true;
  }
  return false;
}

}  // namespace

void skin_begin_loose(SkinState* s) {
  s->back.flying = s->back.lying = 0;
  s->cursor = 0;
}

// Those that fly are written from the front of the list on, those that lie from its end on.
bool skin_loose(SkinState* s) {
  SkinMesh& back = s->back;
  const uint32_t most = s->taken_count - s->cursor;
  const uint32_t end = s->cursor + (most < k_skin_unit_items ? most : k_skin_unit_items);
  uint32_t last = k_brick_none;
  for (; s->cursor < end; ++s->cursor) {
    const SkinTaken& p = s->taken[s->cursor];
    sandglass_skin_loose one;
    if (!loose_of(*s, p, &last, &one)) continue;
    back.loose[p.flies ? back.flying++ : s->desc.particle_capacity - ++back.lying] = one;
  }
  if (s->cursor < s->taken_count) return false;
  memmove(back.loose + back.flying, back.loose + s->desc.particle_capacity - back.lying,
          back.lying * sizeof *back.loose);
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    Brick& brick = s->bricks[b];
    if (!brick.used) continue;
    if ((brick.stale & k_stale_mesh) != 0) memset(s->nodes[b].changed, 0, sizeof s->nodes[b].changed);
    brick.stale &= ~k_stale_mesh;
    if (!is_needed(*s, brick)) brick_release(s, b);
  }
  return true;
}

}  // namespace sandglass
