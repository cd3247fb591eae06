// The C API around a relief: checks, layout, where the plane is, and what it looks like from outside.
#include "runtime/frame/create.h"
#include "kernels/whole.h"
#include "platform/floating_point.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/hash.h"
#include "runtime/math/turn.h"
#include "runtime/relief/relief.h"

namespace sandglass {

void relief_show(ReliefState* relief, uint32_t i, int16_t height) {
  const float metres = relief->gone[i] != 0 ? SANDGLASS_RELIEF_GONE : static_cast<float>(height) * k_relief_unit;
  relief->cells.shown[i] = height;
  if (relief->heights[i] == metres) return;
  CellChange* change = &relief->changes[i];
  if (change->last <= relief->change) *change = {relief->change + 1, change->last, relief->heights[i]};
  relief->heights[i] = metres;
  relief->changes_now = true;
}

void relief_set_cell(ReliefState* relief, uint32_t i, int16_t height) {
  const ReliefCells& cells = relief->cells;
  for (uint32_t k = 0; k < k_relief_looks; ++k) cells.looks[k * cells.pitch + i] = INT16_MAX;
  cells.median[i] = height;
  cells.seen[i] = cells.next[i] = cells.beyond[i] = cells.calm[i] = 0;
  relief_show(relief, i, height);
}

void relief_reset(ReliefState* relief) {
  const uint32_t count = relief_cells(*relief);
  for (uint32_t i = 0; i < count; ++i) {
    relief_set_cell(relief, i, 0);
    relief->cells.now[i] = relief->raised.given[i] = k_relief_none;
  }
  relief_end_change(relief);
  relief->raised.due = relief->raised.count != 0;
  relief->scale = 1;
  relief->scale_known = false;
  relief->last_ns = 0;
  relief->changed = {{0, 0}, {relief->desc.cells[0], relief->desc.cells[1]}};
  ++relief->version;
  relief->phase = ReliefPhase::idle;
  relief->cursor = 0;
}

namespace {

constexpr float k_limit = SANDGLASS_COORDINATE_LIMIT;

sandglass_status check(const sandglass_relief_desc& desc, const char** reason) {
  for (const uint32_t cells : desc.cells)
    if (cells < 16 || cells > 256) return refuse(reason, "desc.cells is not in 16..256 along x and along z.");
  if (!within(desc.cell, 0.005f, 0.05f)) return refuse(reason, "desc.cell is not in 0.005..0.05 metres.");
  if (!within(desc.ceiling, 0.01f, 0.5f)) return refuse(reason, "desc.ceiling is not in 0.01..0.5 metres.");
  if (desc.mesh_capacity > 1024) return refuse(reason, "desc.mesh_capacity is above 1024.");
  return accept(reason);
}

sandglass_relief* lay_out(const sandglass_relief_desc& desc, Layout* layout) {
  const uint64_t count = uint64_t{desc.cells[0]} * desc.cells[1];
  auto* handle = layout_region<sandglass_relief>(layout, "relief", 1);
  ReliefState nowhere = {};
  ReliefState* relief = handle == nullptr ? &nowhere : &handle->relief;
  ReliefCells* cells = &relief->cells;
  cells->pitch = static_cast<uint32_t>((count + k_relief_lanes - 1) / k_relief_lanes * k_relief_lanes);
  cells->looks = layout_region<int16_t>(layout, "relief.looks", uint64_t{k_relief_looks} * cells->pitch);
  int16_t** const heights[] = {&cells->median, &cells->shown, &cells->now};
  for (int16_t** array : heights) *array = layout_region<int16_t>(layout, "relief.cells", count);
  uint8_t** const counts[] = {&cells->seen, &cells->next, &cells->beyond, &cells->calm};
  for (uint8_t** array : counts) *array = layout_region<uint8_t>(layout, "relief.counts", count);
  relief->raised.meshes = layout_region<ReliefMesh>(layout, "relief.meshes", desc.mesh_capacity);
  int16_t** const raised[] = {&relief->raised.made, &relief->raised.given};
  for (int16_t** array : raised) *array = layout_region<int16_t>(layout, "relief.raised", count);
  relief->gone = layout_region<uint8_t>(layout, "relief.gone", count);
  relief->heights = layout_region<float>(layout, "relief.heights", count + 1);
  relief->changes = layout_region<CellChange>(layout, "relief.changes", count);
  relief->samples = layout_region<uint16_t>(layout, "relief.samples", k_relief_samples);
  return handle;
}

sandglass_status build(const sandglass_relief_desc& desc, sandglass_relief* handle, const char** reason) {
  handle->member.capability = &k_relief_capability;
  ReliefState* relief = &handle->relief;
  relief->magic = k_relief_magic;
  relief->change = 1;
  relief->desc = desc;
  relief->rotation[3] = 1;
  relief->per_metre = 1 / desc.cell;
  for (int k = 0; k < 2; ++k) relief->middle[k] = 0.5f * static_cast<float>(desc.cells[k]);
  relief_reset(relief);
  relief->version = 0;
  return accept(reason);
}

using Maker = MakerOf<check, lay_out, build>;

// Out of line: each runs between the two calls that set and restore the floating-point control.
__attribute__((noinline)) bool take_whole(ReliefState* relief, const sandglass_depth_image& image) {
  while (!relief_idle(*relief)) relief_run_unit(relief);
  if (!relief_take(relief, image)) return false;
  while (!relief_idle(*relief)) relief_run_unit(relief);
  return true;
}

__attribute__((noinline)) void fill_heights(const ReliefState& relief, sandglass_heights* out) {
  sandglass_heights heights = {};
  heights.heights = relief.heights;
  heights.cell = relief.desc.cell;
  heights.depth_scale = relief.scale;
  heights.version = relief.version;
  Rotation plane = {};
  rotation_of(relief.rotation, &plane);
  float* const edges[2] = {heights.along, heights.across};
  double corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = static_cast<double>(relief.position[k]);
  for (uint32_t i = 0; i < 2; ++i) {
    heights.cells[i] = relief.desc.cells[i];
    heights.low[i] = relief.changed.low[i];
    heights.high[i] = relief.changed.high[i];
    const double side = static_cast<double>(relief.desc.cell) * relief.desc.cells[i];
    for (int k = 0; k < 3; ++k) {
      edges[i][k] = static_cast<float>(side * plane.m[k][2 * i]);
      corner[k] -= 0.5 * side * plane.m[k][2 * i];
    }
  }
  for (int k = 0; k < 3; ++k) {
    heights.corner[k] = static_cast<float>(corner[k]);
    heights.up[k] = static_cast<float>(plane.m[k][1]);
  }
  fill_struct(&heights, sizeof heights, out);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_relief_desc_default(sandglass_relief_desc* desc) {
  if (!empty_struct(desc)) return;
  desc->cells[0] = desc->cells[1] = 128;
  desc->cell = 0.01f;
  desc->mesh_capacity = 64;
  desc->ceiling = 0.5f;
}

sandglass_status sandglass_relief_bytes(const sandglass_relief_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_relief_create(const sandglass_relief_desc* desc, void* block, uint64_t bytes,
                                         sandglass_relief** relief, const char** reason) {
  return create_in<Maker>(desc, block, bytes, relief, "relief is NULL: pass where to store it.", reason);
}

void sandglass_relief_reset(sandglass_relief* relief) {
  if (relief != nullptr) relief_reset(&relief->relief);
}

sandglass_status sandglass_relief_set_plane(sandglass_relief* handle, const float position[3], const float rotation[4],
                                            const char** reason) {
  if (handle == nullptr || position == nullptr || rotation == nullptr)
    return refuse(reason, "relief, position or rotation is NULL: pass all three.");
  if (!all_within(position, 3, -k_limit, k_limit))
    return refuse(reason, "position is not finite or beyond 1000 m: keep the world near its origin.");
  const ExactFloatingPoint exact;
  Rotation turn = {};
  if (!rotation_of(rotation, &turn)) return refuse(reason, "rotation is none: pass (x, y, z, w), not all 0.");
  __builtin_memcpy(handle->relief.position, position, sizeof handle->relief.position);
  __builtin_memcpy(handle->relief.rotation, rotation, sizeof handle->relief.rotation);
  relief_meshes_moved(&handle->relief);
  return accept(reason);
}

void sandglass_depth_image_default(sandglass_depth_image* image) {
  if (!empty_struct(image)) return;
  image->to_metres = 0.001f;
  image->orientation[3] = 1;
}

sandglass_status sandglass_relief_set_image(sandglass_relief* relief, const sandglass_depth_image* image,
                                            int32_t* taken, const char** reason) {
  if (taken != nullptr) *taken = 0;
  if (relief == nullptr || image == nullptr) return refuse(reason, "relief or image is NULL: pass both.");
  const ExactFloatingPoint exact;
  if (const char* fault = relief_fault(*image)) return refuse(reason, fault);
  const bool took = take_whole(&relief->relief, *image);
  if (taken != nullptr) *taken = took ? 1 : 0;
  return accept(reason);
}

uint32_t sandglass_relief_run(sandglass_relief* relief, uint32_t units) {
  if (relief == nullptr) return 0;
  const ExactFloatingPoint exact;
  return run_members(member_of(relief, k_relief_kinds), units);
}

void sandglass_relief_get_heights(const sandglass_relief* relief, sandglass_heights* heights) {
  if (relief != nullptr && heights != nullptr) fill_heights(relief->relief, heights);
}

void sandglass_relief_get_collider(const sandglass_relief* relief, sandglass_collider* collider) {
  if (relief == nullptr || collider == nullptr) return;
  *collider = {};
  collider->shape = SANDGLASS_SHAPE_RELIEF;
  __builtin_memcpy(collider->position, relief->relief.position, sizeof collider->position);
  __builtin_memcpy(collider->rotation, relief->relief.rotation, sizeof collider->rotation);
  collider->relief = relief;
}

uint64_t sandglass_relief_hash(const sandglass_relief* handle) {
  if (handle == nullptr) return 0;
  const ReliefState& relief = handle->relief;
  const uint64_t count = relief_cells(relief);
  uint64_t hash = hash_bytes(relief.cells.looks, sizeof(int16_t) * k_relief_looks * relief.cells.pitch);
  hash = hash_with(hash, hash_bytes(relief.cells.shown, sizeof(int16_t) * count));
  hash = hash_with(hash, hash_bytes(relief.raised.given, sizeof(int16_t) * count));
  const uint8_t* const arrays[] = {relief.cells.beyond, relief.cells.calm, relief.gone};
  for (const uint8_t* array : arrays) hash = hash_with(hash, hash_bytes(array, count));
  return hash_with(hash, hash_bytes(&relief.scale, sizeof relief.scale));
}
