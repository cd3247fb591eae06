// What of the sand is not in the mesh: what flies, and what lies in too thin a density. And the end of a skin: bricks that
// nothing needs any more are released, and the two meshes change places.
#include <cstring>

#include "runtime/granular/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_flies = 0.35f;  // m/s
constexpr float k_least_weight = 0.04f;
constexpr float k_thin = 0.45f, k_thick = 0.95f;  // of the level: none of it is in the mesh, all of it is

// The density at a place in lattice steps; its gradient, in nodes.
float density_at(const SkinState& s, const int32_t place[3], float gradient[3]) {
  int32_t cell[3], at[3];
  float u[3], value = 0;
  gradient[0] = gradient[1] = gradient[2] = 0;
  for (uint32_t a = 0; a < 3; ++a) {
    cell[a] = place[a] >> 7, at[a] = cell[a] >> 3;
    u[a] = static_cast<float>(place[a] & (k_skin_steps - 1)) * (1.0f / k_skin_steps);
  }
  const uint32_t number = brick_find(s, at);
  if (number == k_brick_none) return 0;
  const Brick& brick = s.bricks[number];
  for (uint32_t c = 0; c < 8; ++c) {
    const uint32_t x = static_cast<uint32_t>(cell[0] & 7) + (c & 1), y = static_cast<uint32_t>(cell[1] & 7) + (c >> 1 & 1);
    const uint32_t z = static_cast<uint32_t>(cell[2] & 7) + (c >> 2);
    const uint32_t other = brick.around[k_brick_itself + (x >> 3) + 3 * (z >> 3) + 9 * (y >> 3)];
    if (other == k_brick_none) continue;
    const float v = static_cast<float>(s.nodes[other].calm[(x & 7) + 8 * (z & 7) + 64 * (y & 7)]);
    const float wx = (c & 1) != 0 ? u[0] : 1.0f - u[0], wy = (c & 2) != 0 ? u[1] : 1.0f - u[1];
    const float wz = (c & 4) != 0 ? u[2] : 1.0f - u[2];
    value += v * wx * wy * wz;
    gradient[0] += ((c & 1) != 0 ? v : -v) * wy * wz;
    gradient[1] += ((c & 2) != 0 ? v : -v) * wx * wz;
    gradient[2] += ((c & 4) != 0 ? v : -v) * wx * wy;
  }
  return value;
}

// False: all of it is in the mesh.
bool loose_of(const SkinState& s, const Particle& p, sandglass_skin_loose* out, bool* flies) {
  constexpr float k_from = k_thin * k_skin_level, k_over = (k_thick - k_thin) * k_skin_level;
  int32_t place[3];
  float gradient[3];
  skin_place(s, p.position, place);
  const float t = (density_at(s, place, gradient) - k_from) * (1.0f / k_over);
  const float weight = t < 0 ? 1.0f : t < 1 ? 1.0f - t * t * (3.0f - 2.0f * t) : 0.0f;
  if (weight < k_least_weight) return false;
  *out = {};
  memcpy(out->position, p.position, sizeof out->position);
  out->weight = weight;
  out->number = number_of(p);
  const float* v = p.velocity;
  *flies = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] > k_flies * k_flies;
  if (*flies) {
    memcpy(out->way, v, sizeof out->way);
    return true;
  }
  const float square = gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
  const float scale = square > 6400.0f ? -1.0f / __builtin_sqrtf(square) : 0.0f;
  for (uint32_t a = 0; a < 3; ++a)
    out->way[s.axis[a]] = s.sign[a] * (scale != 0.0f ? scale * gradient[a] : s.up[a]);
  return true;
}

bool is_needed(const SkinState& s, const Brick& brick) {
  if (brick.count != 0 || brick.high != 0) return true;
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
  const Particles& particles = s->granular->particles;
  const uint32_t most = particles.count - (s->cursor < particles.count ? s->cursor : particles.count);
  const uint32_t end = s->cursor + (most < k_skin_unit_items ? most : k_skin_unit_items);
  for (; s->cursor < end; ++s->cursor) {
    const Particle& p = particles.records[0][s->cursor];
    if (in_body(p) || has_departed(p)) continue;
    if (back.flying + back.lying == s->desc.particle_capacity) continue;
    sandglass_skin_loose one;
    bool flies;
    if (!loose_of(*s, p, &one, &flies)) continue;
    back.loose[flies ? back.flying++ : s->desc.particle_capacity - ++back.lying] = one;
  }
  if (s->cursor < particles.count) return false;
  memmove(back.loose + back.flying, back.loose + s->desc.particle_capacity - back.lying, back.lying * sizeof *back.loose);
  for (uint32_t b = 0; b < s->brick_count; ++b) {
    Brick& brick = s->bricks[b];
    if (brick.used == 0) continue;
    brick.stale &= ~k_stale_mesh;
    if (!is_needed(*s, brick)) brick_release(s, b);
  }
  return true;
}

}  // namespace sandglass
