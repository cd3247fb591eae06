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

void lay_out_mesh(const SkinState& s, Layout* layout, SkinMesh* mesh, float** from) {
  mesh->vertices = layout_region<sandglass_skin_vertex>(layout, "skin.vertices", s.meshes.vertex_capacity);
  mesh->anchors = layout_region<uint32_t>(layout, "skin.anchors", s.meshes.vertex_capacity);
  mesh->indices = layout_region<uint16_t>(layout, "skin.indices", s.meshes.index_capacity);
  mesh->loose = layout_region<sandglass_skin_loose>(layout, "skin.loose", s.desc.particle_capacity);
  mesh->chunks = layout_region<sandglass_skin_chunk>(layout, "skin.chunks", s.bricks.chunks.capacity);
  mesh->first_vertex = layout_region<uint32_t>(layout, "skin.first_vertices", s.bricks.chunks.capacity);
  mesh->first_index = layout_region<uint32_t>(layout, "skin.first_indices", s.bricks.chunks.capacity);
  *from = layout_region<float>(layout, "skin.from", uint64_t{3} * s.desc.particle_capacity);
}

// The one walk: counts the bytes, or hands out the regions. Capacities by what piles, layers and strewn sand take.
sandglass_skin* lay_out(const sandglass_skin_desc& desc, Layout* layout) {
  auto* handle = layout_region<sandglass_skin>(layout, "skin.state", 1);
  SkinState nowhere = {};
  SkinState* s = handle == nullptr ? &nowhere : &handle->skin;
  if (handle != nullptr) *handle = {};
  s->desc = desc;
  const uint32_t n = desc.particle_capacity;
  s->bricks.capacity = 96 + n / 16;
  s->bricks.chunks.capacity = 16 + s->bricks.capacity / 8;
  s->meshes.vertex_capacity = 2048 + (desc.capped != 0 ? 8 : 4) * n;
  s->meshes.index_capacity = 6 * s->meshes.vertex_capacity;
  uint32_t slots = 64;
  while (slots < 2 * s->bricks.capacity) slots *= 2;
  s->bricks.slot_mask = slots - 1;
  s->solids.colliders = layout_region<ColliderFrame>(layout, "skin.colliders", desc.collider_capacity);
  s->solids.fields = layout_region<uint64_t>(layout, "skin.fields", desc.collider_capacity);
  s->carry.met = layout_region<ColliderFrame>(layout, "skin.met", desc.collider_capacity);
  s->solids.movers = layout_region<uint32_t>(layout, "skin.movers", desc.collider_capacity);
  s->sand.taken = layout_region<SkinTaken>(layout, "skin.taken", n);
  s->sand.particles = layout_region<SkinParticle>(layout, "skin.particles", n);
  s->bricks.records = layout_region<Brick>(layout, "skin.bricks", s->bricks.capacity);
  s->bricks.nodes = layout_region<BrickNodes>(layout, "skin.nodes", s->bricks.capacity);
  s->bricks.slots = layout_region<uint32_t>(layout, "skin.slots", slots);
  s->bricks.free = layout_region<uint32_t>(layout, "skin.free_bricks", s->bricks.capacity);
  s->fill.work = layout_region<uint32_t>(layout, "skin.work", s->bricks.capacity);
  s->bricks.chunks.records = layout_region<SkinChunk>(layout, "skin.places", s->bricks.chunks.capacity);
  s->bricks.chunks.order = layout_region<uint32_t>(layout, "skin.order", s->bricks.chunks.capacity);
  s->meshes.outer = layout_region<uint16_t>(layout, "skin.outer", k_outer_bricks * k_brick_nodes);
  s->meshes.blocks = layout_region<SkinBlocks>(layout, "skin.blocks", 1);
  s->solids.points = layout_region<SurfacePoint>(layout, "skin.points", k_edges_nodes + k_lane_group);
  lay_out_mesh(*s, layout, &s->meshes.front, &s->carry.from);
  lay_out_mesh(*s, layout, &s->meshes.back, &s->sand.from);
  s->shown.vertices = layout_region<sandglass_skin_vertex>(layout, "skin.shown", s->meshes.vertex_capacity);
  s->shown.chunks = layout_region<sandglass_skin_chunk>(layout, "skin.shown_chunks", s->bricks.chunks.capacity);
  s->shown.loose = layout_region<sandglass_skin_loose>(layout, "skin.shown_loose", n);
  s->carry.carried = layout_region<SkinCarried>(layout, "skin.carried", n);
  return handle;
}

sandglass_status build(const sandglass_skin_desc& desc, sandglass_skin* handle, const char** reason) {
  handle->member.capability = &k_skin_capability;
  SkinState* s = &handle->skin;
  s->lattice.spacing = k_skin_spacing * desc.particle_radius;
  s->lattice.inverse_spacing = 1.0f / s->lattice.spacing;
  s->carry.inverse_side = 1.0f / desc.block_side;
  s->progress.in_time = k_skin_in_time;
  for (uint32_t v = 0; v < 256; ++v) {
    const uint32_t free = skin_free(static_cast<uint8_t>(v)), bounded = free < 64 ? 64 : free;
    s->filter.by_free[v] = static_cast<uint16_t>(free < 5 ? 0 : 256 * k_skin_one / bounded);
  }
  s->solids.solid_before = s->meshes.blocks->solid;
  s->solids.walls_before = s->meshes.blocks->walls;
  for (uint32_t i = 0; i < desc.particle_capacity; ++i) s->sand.from[3 * i] = s->carry.from[3 * i] = k_skin_nowhere;
  SkinMesh* const meshes[] = {&s->meshes.front, &s->meshes.back};
  for (SkinMesh* mesh : meshes)
    for (uint32_t c = 0; c < s->bricks.chunks.capacity; ++c) {
      mesh->chunks[c] = s->shown.chunks[c] = {};
      mesh->first_vertex[c] = mesh->first_index[c] = 0;
    }
  ColliderFrame none = {};
  none.shape = k_no_shape;
  for (uint32_t c = 0; c < desc.collider_capacity; ++c) {
    s->solids.colliders[c] = s->carry.met[c] = none;
    s->solids.fields[c] = 0;
  }
  for (uint32_t a = 0; a < 3; ++a) {
    s->lattice.axis[a] = a;
    s->lattice.sign[a] = 1.0f;
  }
  s->lattice.up[1] = 1.0f;
  s->lattice.falls = true;
  bricks_forget(&s->bricks);
  sand_forget(&s->sand, desc.particle_capacity);
  s->requests.asked = true;
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
  mesh.version = s.shown.version;
  const bool stale = s.requests.asked || s.progress.phase != SkinPhase::idle;
  mesh.frames_behind = stale ? static_cast<uint32_t>(s.frame - s.shown.begun) : 0;
  mesh.chunks = s.shown.chunks;
  mesh.chunk_count = s.bricks.chunks.capacity;
  for (uint32_t c = 0; c < s.bricks.chunks.capacity; ++c) {
    mesh.vertex_count += s.shown.chunks[c].vertex_count;
    mesh.index_count += s.shown.chunks[c].index_count;
  }
  mesh.loose = s.shown.loose;
  mesh.flying_count = s.shown.flying;
  mesh.lying_count = s.shown.lying;
  mesh.left_out = s.shown.left_out;
  fill_struct(&mesh, sizeof mesh, out);
}

void sandglass_skin_refresh(sandglass_skin* skin) {
  if (skin != nullptr) skin->skin.requests.asked = skin->skin.requests.whole_asked = true;
}

uint64_t sandglass_skin_hash(const sandglass_skin* skin) {
  if (skin == nullptr) return 0;
  const SkinState& s = skin->skin;
  uint64_t hash = k_hash_basis;
  for (uint32_t c = 0; c < s.bricks.chunks.capacity; ++c) {
    const sandglass_skin_chunk& chunk = s.shown.chunks[c];
    if (chunk.index_count == 0) continue;
    hash = hash_bytes(chunk.vertices, chunk.vertex_count * sizeof *chunk.vertices, hash);
    hash = hash_bytes(chunk.indices, chunk.index_count * sizeof *chunk.indices, hash);
  }
  return hash_bytes(s.shown.loose, (s.shown.flying + s.shown.lying) * sizeof *s.shown.loose, hash);
}
