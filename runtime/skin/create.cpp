// The C API around a skin: checks, layout, and what it looks like from outside.
#include <cstring>

#include "platform/floating_point.h"
#include "runtime/frame/create.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/skin/skin.h"

namespace sandglass {
namespace {

sandglass_status check(const sandglass_skin_desc& desc, const char** reason) {
  if (desc.particle_capacity == 0 || desc.particle_capacity > 4'000'000)
    return refuse(reason, "desc.particle_capacity is not in 1..4000000: take the scene's.");
  if (!within(desc.particle_radius, 0.0001f, 10.0f))
    return refuse(reason, "desc.particle_radius is not in 0.0001..10 metres: take the scene's.");
  if (desc.collider_capacity > 256) return refuse(reason, "desc.collider_capacity is above 256: take the scene's.");
  if (!within(desc.block_side, 0.0001f, 1.0f)) return refuse(reason, "desc.block_side is not in 0.0001..1 metres.");
  if (desc.first_vertex > 1) return refuse(reason, "desc.first_vertex is neither 0 nor 1.");
  if (desc.capped > 1) return refuse(reason, "desc.capped is neither 0 nor 1.");
  return accept(reason);
}

void lay_out_mesh(const SkinState& s, Layout* layout, SkinMesh* mesh) {
  mesh->vertices = layout_region<sandglass_skin_vertex>(layout, "skin.vertices", s.vertex_capacity);
  mesh->anchors = layout_region<uint32_t>(layout, "skin.anchors", s.vertex_capacity);
  mesh->indices = layout_region<uint16_t>(layout, "skin.indices", s.index_capacity);
  mesh->loose = layout_region<sandglass_skin_loose>(layout, "skin.loose", s.desc.particle_capacity);
  mesh->chunks = layout_region<sandglass_skin_chunk>(layout, "skin.chunks", s.chunk_capacity);
  mesh->first_vertex = layout_region<uint32_t>(layout, "skin.first_vertices", s.chunk_capacity);
  mesh->first_index = layout_region<uint32_t>(layout, "skin.first_indices", s.chunk_capacity);
  mesh->from = layout_region<float>(layout, "skin.from", uint64_t{3} * s.desc.particle_capacity);
}

// The one walk: counts the bytes, or hands out the regions. Capacities by what heaps, layers and strewn sand take.
sandglass_skin* lay_out(const sandglass_skin_desc& desc, Layout* layout) {
  auto* owner = layout_region<sandglass_skin>(layout, "skin.state", 1);
  SkinState nowhere = {};
  SkinState* s = owner == nullptr ? &nowhere : &owner->skin;
  if (owner != nullptr) *owner = {};
  s->desc = desc;
  const uint32_t n = desc.particle_capacity;
  s->brick_capacity = 96 + n / 16;
  s->chunk_capacity = 16 + s->brick_capacity / 8;
  s->vertex_capacity = 2048 + (desc.capped != 0 ? 8 : 4) * n;
  s->index_capacity = 6 * s->vertex_capacity;
  uint32_t slots = 64;
  while (slots < 2 * s->brick_capacity) slots *= 2;
  s->slot_mask = slots - 1;
  s->colliders = layout_region<ColliderFrame>(layout, "skin.colliders", desc.collider_capacity);
  s->fields = layout_region<uint64_t>(layout, "skin.fields", desc.collider_capacity);
  s->met = layout_region<ColliderFrame>(layout, "skin.met", desc.collider_capacity);
  s->movers = layout_region<uint32_t>(layout, "skin.movers", desc.collider_capacity);
  s->taken = layout_region<SkinTaken>(layout, "skin.taken", n);
  s->particles = layout_region<SkinParticle>(layout, "skin.particles", n);
  s->bricks = layout_region<Brick>(layout, "skin.bricks", s->brick_capacity);
  s->nodes = layout_region<BrickNodes>(layout, "skin.nodes", s->brick_capacity);
  s->slots = layout_region<uint32_t>(layout, "skin.slots", slots);
  s->free_bricks = layout_region<uint32_t>(layout, "skin.free_bricks", s->brick_capacity);
  s->work = layout_region<uint32_t>(layout, "skin.work", s->brick_capacity);
  s->chunks = layout_region<SkinChunk>(layout, "skin.places", s->chunk_capacity);
  s->chunk_order = layout_region<uint32_t>(layout, "skin.order", s->chunk_capacity);
  s->outer = layout_region<uint16_t>(layout, "skin.outer", k_outer_bricks * k_brick_nodes);
  s->blocks = layout_region<SkinBlocks>(layout, "skin.blocks", 1);
  s->points = layout_region<SurfacePoint>(layout, "skin.points", k_edges_nodes + k_lane_group);
  lay_out_mesh(*s, layout, &s->front);
  lay_out_mesh(*s, layout, &s->back);
  s->shown.vertices = layout_region<sandglass_skin_vertex>(layout, "skin.shown", s->vertex_capacity);
  s->shown.chunks = layout_region<sandglass_skin_chunk>(layout, "skin.shown_chunks", s->chunk_capacity);
  s->shown.loose = layout_region<sandglass_skin_loose>(layout, "skin.shown_loose", n);
  s->carried = layout_region<SkinCarried>(layout, "skin.carried", n);
  return owner;
}

sandglass_status build(const sandglass_skin_desc& desc, sandglass_skin* owner, const char** reason) {
  owner->member.capability = &k_skin_capability;
  SkinState* s = &owner->skin;
  s->spacing = k_skin_spacing * desc.particle_radius;
  s->inverse_spacing = 1.0f / s->spacing;
  s->inverse_side = 1.0f / desc.block_side;
  s->in_time = k_skin_in_time;
  for (uint32_t v = 0; v < 256; ++v) {
    const uint32_t free = skin_free(static_cast<uint8_t>(v)), least = free < 64 ? 64 : free;
    s->by_free[v] = static_cast<uint16_t>(free < 5 ? 0 : 256 * k_skin_one / least);
  }
  SkinMesh* const meshes[] = {&s->front, &s->back};
  for (SkinMesh* mesh : meshes) {
    for (uint32_t i = 0; i < desc.particle_capacity; ++i) mesh->from[3 * i] = k_skin_nowhere;
    for (uint32_t c = 0; c < s->chunk_capacity; ++c) {
      mesh->chunks[c] = s->shown.chunks[c] = {};
      mesh->first_vertex[c] = mesh->first_index[c] = 0;
    }
  }
  ColliderFrame none = {};
  none.shape = k_no_shape;
  for (uint32_t c = 0; c < desc.collider_capacity; ++c) {
    s->colliders[c] = s->met[c] = none;
    s->fields[c] = 0;
  }
  for (uint32_t a = 0; a < 3; ++a) {
    s->axis[a] = a;
    s->sign[a] = 1.0f;
  }
  s->up[1] = 1.0f;
  s->falls = true;
  skin_forget(s);
  s->asked = true;
  return accept(reason);
}

using Maker = MakerOf<check, lay_out, build>;

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_skin_desc_default(sandglass_skin_desc* desc, const sandglass_granular_desc* granular) {
  if (!empty_struct(desc)) return;
  desc->particle_radius = 0.01f;
  desc->collider_capacity = 16;
  desc->block_side = 0.0084f;
  if (granular == nullptr) return;
  desc->particle_capacity = granular->particle_capacity;
  desc->particle_radius = granular->particle_radius;
  desc->collider_capacity = granular->collider_capacity;
}

sandglass_status sandglass_skin_bytes(const sandglass_skin_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_skin_create(const sandglass_skin_desc* desc, void* block, uint64_t bytes,
                                       sandglass_skin** skin, const char** reason) {
  return create_in<Maker>(desc, block, bytes, skin, "skin is NULL: pass where to store it.", reason);
}

void sandglass_skin_get_mesh(const sandglass_skin* skin, sandglass_skin_mesh* out) {
  if (skin == nullptr || out == nullptr) return;
  const SkinState& s = skin->skin;
  sandglass_skin_mesh mesh = {};
  mesh.valid = s.valid || s.shown.flying + s.shown.lying != 0 ? 1 : 0;
  mesh.version = s.version;
  const bool stale = s.asked || s.phase != SkinPhase::idle;
  mesh.frames_behind = stale ? static_cast<uint32_t>(s.frame - s.front_frame) : 0;
  mesh.chunks = s.shown.chunks;
  mesh.chunk_count = s.chunk_capacity;
  for (uint32_t c = 0; c < s.chunk_capacity; ++c) {
    mesh.vertex_count += s.shown.chunks[c].vertex_count;
    mesh.index_count += s.shown.chunks[c].index_count;
  }
  mesh.loose = s.shown.loose;
  mesh.flying_count = s.shown.flying;
  mesh.lying_count = s.shown.lying;
  mesh.left_out = s.left_out;
  fill_struct(&mesh, sizeof mesh, out);
}

void sandglass_skin_refresh(sandglass_skin* skin) {
  if (skin != nullptr) skin->skin.asked = skin->skin.whole_asked = true;
}

uint64_t sandglass_skin_hash(const sandglass_skin* skin) {
  if (skin == nullptr) return 0;
  const SkinState& s = skin->skin;
  uint64_t hash = k_hash_basis;
  for (uint32_t c = 0; c < s.chunk_capacity; ++c) {
    const sandglass_skin_chunk& chunk = s.shown.chunks[c];
    if (chunk.index_count == 0) continue;
    hash = hash_bytes(chunk.vertices, chunk.vertex_count * sizeof *chunk.vertices, hash);
    hash = hash_bytes(chunk.indices, chunk.index_count * sizeof *chunk.indices, hash);
  }
  return hash_bytes(s.shown.loose, (s.shown.flying + s.shown.lying) * sizeof *s.shown.loose, hash);
}
