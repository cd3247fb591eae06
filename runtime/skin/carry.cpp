// A skin that takes longer than a frame. Until it is complete, the one that is shown is carried along: each vertex goes as
// far as its particle has gone since that was gathered, and loose sand is where its particles are. So sand moves in every
// frame, however slow the processor is. What is made goes on from the mesh as it was made.
//
// One unit does all, so that no frame shows a mesh of two moments.
#include <cstring>

#include "runtime/granular/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

constexpr float k_most_radii = 1.5f;       // that a vertex is carried: about a node
constexpr uint32_t k_most_items = 16'000;  // one unit's: about 0.2 ms of a phone

uint32_t items(const SkinState& s) { return s.granular->particles.count + s.front.vertex_count; }

bool same_bytes(const void* a, const void* b, size_t count) { return memcmp(a, b, count) == 0; }

// How far each particle has gone, by number, and which record it is.
void find_ways(SkinState* s) {
  const float most = k_most_radii * s->desc.particle_radius;
  const float least = static_cast<float>(k_skin_held) / k_skin_steps * s->spacing;
  for (uint32_t i = 0; i < s->desc.particle_capacity; ++i) s->carried[i] = {{0, 0, 0}, k_brick_none};
  const Particles& particles = s->granular->particles;
  for (uint32_t i = 0; i < particles.count; ++i) {
    const Particle& p = particles.records[0][i];
    const uint32_t number = number_of(p);
    if (number >= s->desc.particle_capacity || in_body(p) || has_departed(p)) continue;
    SkinCarried& carried = s->carried[number];
    carried.record = i;
    const float* from = s->front.from + 3 * number;
    float way[3], square = 0;
    for (uint32_t k = 0; k < 3; ++k) way[k] = p.position[k] - from[k], square += way[k] * way[k];
    if (!(square > least * least)) continue;
    const float scale = square > most * most ? most / __builtin_sqrtf(square) : 1.0f;
    for (uint32_t k = 0; k < 3; ++k) carried.way[k] = scale * way[k];
  }
}

// In 1/65536 of the block's side, modulo that.
uint16_t turned(uint16_t origin, float turns) {
  const float part = turns - static_cast<float>(floor_whole(turns));
  return static_cast<uint16_t>(origin + to_whole<uint32_t>(65536.0f * part));
}

// Whether a byte of the chunk that is shown has changed.
bool carry_chunk(SkinState* s, uint32_t c) {
  const sandglass_skin_chunk& made = s->front.chunks[c];
  sandglass_skin_chunk& chunk = s->shown.chunks[c];
  const uint32_t first = s->front.first_vertex[c];
  const sandglass_skin_vertex *from = s->front.vertices + first, *before = chunk.vertices;
  sandglass_skin_vertex* to = s->shown.vertices + first;
  bool differs = false;
  for (uint32_t v = 0; v < made.vertex_count; ++v) {
    sandglass_skin_vertex vertex = from[v];
    const uint32_t anchor = s->front.anchors[first + v];
    if (anchor != k_brick_none)
      for (uint32_t k = 0; k < 3; ++k) {
        const float way = s->carried[anchor].way[k];
        vertex.position[k] += way;
        vertex.origin[k] = turned(vertex.origin[k], way * s->inverse_side);
      }
    differs = differs || !same_bytes(before + v, &vertex, sizeof vertex);
    to[v] = vertex;
  }
  if (!differs) return false;
  const float reach = k_most_radii * s->desc.particle_radius;
  for (uint32_t k = 0; k < 3; ++k) chunk.low[k] = made.low[k] - reach, chunk.high[k] = made.high[k] + reach;
  chunk.vertices = to;
  return true;
}

bool carry_loose(SkinState* s) {
  bool differs = false;
  const uint32_t count = s->front.flying + s->front.lying;
  for (uint32_t i = 0; i < count; ++i) {
    sandglass_skin_loose one = s->front.loose[i];
    const bool known = one.number < s->desc.particle_capacity;  // else it has no skin
    const uint32_t record = known ? s->carried[one.number].record : k_brick_none;
    if (record != k_brick_none)
      memcpy(one.position, s->granular->particles.records[0][record].position, sizeof one.position);
    differs = differs || !same_bytes(s->shown.loose + i, &one, sizeof one);
    s->shown.loose[i] = one;
  }
  return differs;
}

}  // namespace

bool skin_may_carry(const SkinState& s) {
  const uint32_t substeps = s.granular->counts.substeps;
  return s.valid && skin_is_late(s) && substeps != 0 && (s.shown.frame != s.frame || s.shown.substeps != substeps) &&
         items(s) <= k_most_items;
}

WorkUnit skin_carry_unit(const SkinState& s) { return {k_skin_carry, items(s), "skin.carry"}; }

void skin_carry(SkinState* s) {
  find_ways(s);
  bool changed = carry_loose(s);
  for (uint32_t c = 0; c < s->chunk_capacity; ++c) {
    if (s->front.chunks[c].vertex_count == 0 || !carry_chunk(s, c)) continue;
    s->shown.chunks[c].version = s->version + 1;
    changed = true;
  }
  if (changed) ++s->version;
  s->shown.frame = s->frame, s->shown.substeps = s->granular->counts.substeps;
}

}  // namespace sandglass
