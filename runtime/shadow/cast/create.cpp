// The C API around a Cast: checks, layout, what is asked for, and what the textures look like from outside.
#include <cstring>

#include "platform/floating_point.h"
#include "runtime/frame/create.h"
#include "runtime/frame/filled_struct.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "runtime/math/plane_axes.h"
#include "runtime/shadow/cast/cast.h"
#include "runtime/shadow/receiver/cells.h"
#include "runtime/shadow/receiver/light_direction.h"

namespace sandglass {
namespace {

constexpr float k_extent_limit = 1e4f;                      // metres
constexpr double k_origin_kept = 100;                       // metres
constexpr float k_height_min = 0.001f, k_height_max = 100;  // metres
constexpr uint32_t k_cut_triangles = 1024;                  // that one layer cuts

sandglass_status check(const sandglass_cast_desc& desc, const char** reason) {
  if (desc.texels != 0 && desc.texels != 64 && desc.texels != 128 && desc.texels != 256)
    return refuse(reason, "desc.texels is not 0, 64, 128 or 256.");
  if (desc.directions != 32 && desc.directions != 64) return refuse(reason, "desc.directions is neither 32 nor 64.");
  if (desc.ambient_texels != 0 && desc.ambient_texels != 64 && desc.ambient_texels != 128)
    return refuse(reason, "desc.ambient_texels is not 0, 64 or 128.");
  if (desc.texels == 0 && desc.ambient_texels == 0)
    return refuse(reason, "desc.texels and ambient_texels are both 0: there is no texture to make.");
  if (desc.triangle_capacity == 0 || desc.triangle_capacity > 1'000'000)
    return refuse(reason, "desc.triangle_capacity is not in 1..1000000.");
  if (desc.mesh_capacity == 0 || desc.mesh_capacity > 1024)
    return refuse(reason, "desc.mesh_capacity is not in 1..1024.");
  if (desc.layers == 0 || desc.layers > k_cast_layers)
    return refuse(reason, "desc.layers is not in 1..8: 1 for a plane alone, more for what stands on it.");
  if (!within(desc.light_tolerance, 0.0f, 1.0f)) return refuse(reason, "desc.light_tolerance is not in 0..1 radians.");
  if (!within(desc.reach, 0.0f, 1e6f) || (desc.reach > 0 && desc.reach < 2))
    return refuse(reason, "desc.reach is neither 0 nor in 2..1000000.");
  if (select_cast_kernels(desc.isa) == nullptr)
    return refuse(reason, SANDGLASS_ERROR_UNSUPPORTED,
                  "desc.isa is not in this build or on this CPU: use SANDGLASS_ISA_AUTOMATIC.");
  return accept(reason);
}

// The one walk: counts the bytes, or hands out the regions.
sandglass_cast* lay_out(const sandglass_cast_desc& desc, Layout* layout) {
  auto* handle = layout_region<sandglass_cast>(layout, "cast.state", 1);
  CastState nowhere = {};
  CastState* c = handle == nullptr ? &nowhere : &handle->cast;
  if (handle != nullptr) *handle = {};
  const uint64_t widest = desc.texels > desc.ambient_texels ? desc.texels : desc.ambient_texels;
  const uint64_t words = widest * cast_words(static_cast<uint32_t>(widest));
  // An eighth more than asked for, for triangles that the plane cuts into two, and what fills parts up. A higher layer
  // cuts a few large triangles into three, or a ring of a fine mesh.
  const uint32_t eighth = desc.triangle_capacity / 8, few = 2 * desc.triangle_capacity;
  const uint32_t for_layer = few < k_cut_triangles + eighth ? few : k_cut_triangles + eighth;
  c->gathered.room = (desc.triangle_capacity + eighth + (desc.layers - 1) * for_layer +
                      (k_cast_groups * desc.layers + 1) * k_lane_group) /
                     k_lane_group * k_lane_group;
  c->gathered.layers = desc.layers;
  c->request.meshes = layout_region<CastMesh>(layout, "cast.meshes", desc.mesh_capacity);
  for (float*& array : c->gathered.corners)
    array = layout_region<float>(layout, "cast.corners", c->gathered.room + k_lane_group);
  c->drawing.directions =
      layout_region<CastDirection>(layout, "cast.directions", k_cast_ambient_directions + k_cast_other_directions);
  c->drawing.image = layout_region<uint64_t>(layout, "cast.image", words);
  c->drawing.mask = layout_region<uint64_t>(layout, "cast.mask", words);
  for (uint32_t light = 0; light < 2; ++light) {
    const uint64_t counted =
        light == 0 || (desc.texels != 0 && desc.ambient_texels != 0) ? desc.layers * k_cast_planes * words : 0;
    c->drawing.counts[light] = layout_region<uint64_t>(layout, "cast.counts", counted);
    c->drawing.mask_counts[light] = layout_region<uint64_t>(layout, "cast.mask_counts", counted);
  }
  c->calm.values = layout_region<float>(layout, "cast.values", widest * cast_pitch(static_cast<uint32_t>(widest)));
  for (float*& window : c->calm.windows) window = layout_region<float>(layout, "cast.windows", k_cast_rows * widest);
  const uint32_t sides[k_cast_targets] = {desc.texels, desc.ambient_texels};
  for (uint32_t i = 0; i < k_cast_targets; ++i) {
    CastTarget* target = &c->targets[i];
    target->texels = sides[i];
    CastTexture* const textures[] = {&target->front, &target->back};
    for (CastTexture* texture : textures)
      texture->bytes = layout_region<uint8_t>(layout, "cast.texture", uint64_t{desc.layers} * sides[i] * sides[i]);
  }
  return handle;
}

sandglass_status frame_of(const sandglass_cast_plane& plane, CastFrame* frame, const char** reason) {
  if (!all_within(plane.origin, 3, -k_cast_far, k_cast_far))
    return refuse(reason, "plane.origin is not finite, or 1000 km away.");
  for (uint32_t axis = 0; axis < 2; ++axis)
    if (!within(plane.low[axis], -k_cast_far, k_cast_far) || !within(plane.high[axis], -k_cast_far, k_cast_far) ||
        !(plane.high[axis] > plane.low[axis]))
      return refuse(reason, "plane.low and high are not finite, or high is not above low.");
  if (!within(plane.bias, 0.0f, 1.0f)) return refuse(reason, "plane.bias is not in 0..1 metre.");
  if (!within(plane.height, k_height_min, k_height_max))
    return refuse(reason, "plane.height is not in 0.001..100 metres.");
  if (plane.is_virtual > 1) return refuse(reason, "plane.is_virtual is neither 0 nor 1.");
  if (const char* wrong = plane_axes(plane.normal, plane.along, frame->axes)) return refuse(reason, wrong);
  for (uint32_t i = 0; i < 3; ++i) frame->origin[i] = static_cast<double>(plane.origin[i]);
  for (uint32_t axis = 0; axis < 2; ++axis) {
    frame->low[axis] = plane.low[axis];
    frame->high[axis] = plane.high[axis];
  }
  frame->bias = plane.bias;
  frame->height = plane.height;
  frame->is_virtual = plane.is_virtual != 0;
  return accept(reason);
}

// A tracker shifts a plane's origin within the plane, by which nothing changes: its frame keeps the place that is
// nearest to the origin of what is gathered, if that is not so far that floats get coarse.
void keep_origin(const CastState& c, CastFrame* frame) {
  double shift[2];
  if (c.progress.phase == CastPhase::idle &&
      c.targets[k_cast_light].completed + c.targets[k_cast_ambient].completed == 0)
    return;
  for (uint32_t side = 0; side < 2; ++side) {
    const double* axis = frame->axes[2 * side];
    shift[side] = 0;
    for (uint32_t i = 0; i < 3; ++i) shift[side] += axis[i] * (c.gathered.frame.origin[i] - frame->origin[i]);
    if (!(absolute(shift[side]) <= k_origin_kept)) return;
  }
  for (uint32_t side = 0; side < 2; ++side) {
    for (uint32_t i = 0; i < 3; ++i) frame->origin[i] += shift[side] * frame->axes[2 * side][i];
    frame->low[side] = static_cast<float>(static_cast<double>(frame->low[side]) - shift[side]);
    frame->high[side] = static_cast<float>(static_cast<double>(frame->high[side]) - shift[side]);
  }
}

sandglass_status build(const sandglass_cast_desc& desc, sandglass_cast* handle, const char** reason) {
  handle->member.capability = &k_cast_capability;
  CastState* c = &handle->cast;
  c->kernels = select_cast_kernels(desc.isa);
  c->desc = desc;
  sandglass_cast_plane plane;
  sandglass_cast_plane_default(&plane);
  (void)frame_of(plane, &c->request.frame, nullptr);
  c->gathered.frame = c->request.frame;
  for (float& cell : c->request.cells) cell = 1.0f / k_light_cells;
  memcpy(c->drawing.cells, c->request.cells, sizeof c->request.cells);
  c->progress.last_target = k_cast_ambient;
  for (uint32_t i = 0; i < k_cast_targets; ++i) {
    CastTarget* target = &c->targets[i];
    target->front.frame = c->request.frame;
    target->front.open = 1;
    if (i == k_cast_ambient && target->texels != 0)
      memset(target->front.bytes, 255, uint64_t{desc.layers} * target->texels * target->texels);
  }
  return accept(reason);
}

using Maker = MakerOf<check, lay_out, build>;

// Whether arrays have another length, which nothing has announced.
bool silently_longer(const sandglass_cast_mesh& now, const sandglass_cast_mesh& before) {
  return now.positions == before.positions && now.indices == before.indices && now.version == before.version &&
         now.triangle_count != 0 && before.triangle_count != 0 &&
         (now.vertex_count != before.vertex_count || now.triangle_count != before.triangle_count);
}

__attribute__((noinline)) sandglass_status take_meshes(CastState* c, const sandglass_cast_mesh* meshes, uint32_t count,
                                                       const char** reason) {
  if (count > c->desc.mesh_capacity)
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "there are more meshes than desc.mesh_capacity: create a larger cast.");
  uint64_t triangles = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (const char* fault = mesh_fault(meshes[i])) return refuse(reason, fault);
    if (i < c->request.mesh_count && silently_longer(meshes[i], c->request.meshes[i].asked))
      return refuse(reason, "a mesh has other counts, but arrays and version are as before: give it another version.");
    triangles += meshes[i].triangle_count;
  }
  if (triangles > c->desc.triangle_capacity)
    return refuse(
        reason, SANDGLASS_ERROR_CAPACITY,
        "there are more triangles than desc.triangle_capacity: create a larger cast, or pass a coarser mesh.");
  for (uint32_t i = 0; i < count; ++i) c->request.meshes[i].asked = meshes[i];
  for (uint32_t i = c->request.mesh_count; i < count; ++i) c->request.meshes[i].gathered.triangle_count = 0;
  c->request.mesh_count = count;
  cast_compare(c);
  return accept(reason);
}

__attribute__((noinline)) sandglass_status take_light(CastState* c, const float direction[3], float diameter,
                                                      const char** reason) {
  double light[3], largest = 0, chord = 0;
  if (const sandglass_status status = check_light_direction(direction, light, reason)) return status;
  if (!within(diameter, 0.0f, 1.5f)) return refuse(reason, "angular_diameter is not in 0..1.5 radians.");
  for (const double x : light) largest = absolute(x) > largest ? absolute(x) : largest;
  for (double& x : light) x /= largest;
  const double length = square_root(light[0] * light[0] + light[1] * light[1] + light[2] * light[2]);
  for (double& x : light) x /= length;
  const double half = static_cast<double>(diameter > 0 ? diameter : k_usual_diameter) / (4 * k_pi);
  for (uint32_t axis = 0; axis < 3; ++axis)
    chord += (light[axis] - c->request.light[axis]) * (light[axis] - c->request.light[axis]);
  const double tolerance = static_cast<double>(c->desc.light_tolerance), wider = (half - c->request.half) * 2 * k_pi;
  if (c->request.light_known && !(chord > tolerance * tolerance) && !(wider * wider > tolerance * tolerance))
    return accept(reason);
  for (uint32_t axis = 0; axis < 3; ++axis) c->request.light[axis] = light[axis];
  c->request.half = half;
  c->request.light_known = true;
  c->targets[k_cast_light].asked = c->targets[k_cast_light].texels != 0;
  if (cast_share(*c) > 0) c->targets[k_cast_ambient].asked = true;
  return accept(reason);
}

__attribute__((noinline)) sandglass_status take_cells(CastState* c, const float* cells, const char** reason) {
  if (const sandglass_status status = check_cells(cells, reason)) return status;
  memcpy(c->request.cells, cells, sizeof c->request.cells);
  if (!cells_differ(c->drawing.cells, cells)) return accept(reason);
  c->targets[k_cast_ambient].asked = c->targets[k_cast_ambient].texels != 0;
  if (cast_share(*c) > 0) c->targets[k_cast_light].asked = true;
  return accept(reason);
}

void fill_texture(const CastState& c, uint32_t which, sandglass_texture* out) {
  const CastTarget& target = c.targets[which];
  const CastTexture& front = target.front;
  sandglass_texture texture = {};
  texture.valid = target.valid ? 1 : 0;
  texture.bytes = front.bytes;
  texture.side = target.texels;
  texture.scale = 1;
  texture.layers = c.desc.layers;
  texture.height = front.frame.height;
  const CastFrame& frame = front.frame;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double u = frame.axes[0][axis], v = frame.axes[2][axis];
    texture.corner[axis] = static_cast<float>(frame.origin[axis] + front.low[0] * u + front.low[1] * v);
    texture.along[axis] = static_cast<float>(u * front.texel[0] * target.texels);
    texture.across[axis] = static_cast<float>(v * front.texel[1] * target.texels);
    texture.light[axis] = static_cast<float>(front.light[axis]);
    texture.slide[axis] = static_cast<float>(front.slide[0] * u + frame.axes[1][axis] + front.slide[1] * v);
  }
  texture.behind = target.asked || (c.progress.phase != CastPhase::idle && c.progress.target == which) ? 1 : 0;
  texture.version = target.completed;
  fill_struct(&texture, sizeof texture, out);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

void sandglass_cast_desc_default(sandglass_cast_desc* desc) {
  if (!empty_struct(desc)) return;
  desc->texels = 128;
  desc->directions = 64;
  desc->ambient_texels = 64;
  desc->triangle_capacity = 4096;
  desc->mesh_capacity = 16;
  desc->light_tolerance = 0.005f;
  desc->reach = 8;
  desc->layers = 1;
}

sandglass_status sandglass_cast_bytes(const sandglass_cast_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_cast_create(const sandglass_cast_desc* desc, void* block, uint64_t bytes,
                                       sandglass_cast** cast, const char** reason) {
  return create_in<Maker>(desc, block, bytes, cast, "cast is NULL: pass where to store it.", reason);
}

void sandglass_cast_plane_default(sandglass_cast_plane* plane) {
  if (!empty_struct(plane)) return;
  plane->normal[1] = plane->along[0] = 1;
  plane->bias = 0.03f;
  plane->height = 0.15f;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    plane->low[axis] = -0.5f * k_extent_limit;
    plane->high[axis] = 0.5f * k_extent_limit;
  }
}

sandglass_status sandglass_cast_set_plane(sandglass_cast* cast, const sandglass_cast_plane* plane,
                                          const char** reason) {
  if (cast == nullptr || plane == nullptr) return refuse(reason, "cast or plane is NULL: pass both.");
  if (plane->struct_size != sizeof *plane)
    return refuse(reason, "plane.struct_size is not that of this library: start from sandglass_cast_plane_default.");
  const ExactFloatingPoint exact;
  CastFrame frame;
  const sandglass_status status = frame_of(*plane, &frame, reason);
  if (status == SANDGLASS_OK) {
    keep_origin(cast->cast, &frame);
    cast->cast.request.frame = frame;
    cast_compare(&cast->cast);
  }
  return status;
}

void sandglass_cast_mesh_default(sandglass_cast_mesh* mesh) {
  if (mesh == nullptr) return;
  *mesh = {};
  mesh->stride = 12;
  mesh->index_bytes = 4;
  for (uint32_t i = 0; i < 4; ++i) mesh->world_from_mesh[5 * i] = 1;
}

sandglass_status sandglass_cast_set_meshes(sandglass_cast* cast, const sandglass_cast_mesh* meshes, uint32_t count,
                                           const char** reason) {
  if (cast == nullptr || (meshes == nullptr && count != 0))
    return refuse(reason, "cast is NULL, or meshes are NULL while count is above 0.");
  const ExactFloatingPoint exact;
  return take_meshes(&cast->cast, meshes, count, reason);
}

sandglass_status sandglass_cast_set_light(sandglass_cast* cast, const float direction[3], float angular_diameter,
                                          const char** reason) {
  if (cast == nullptr || direction == nullptr)
    return refuse(reason, "cast or direction is NULL: pass the cast and 3 floats.");
  const ExactFloatingPoint exact;
  return take_light(&cast->cast, direction, angular_diameter, reason);
}

sandglass_status sandglass_cast_set_cells(sandglass_cast* cast, const float cells[SANDGLASS_LIGHT_CELLS],
                                          const char** reason) {
  if (cast == nullptr || cells == nullptr) return refuse(reason, "cast or cells is NULL: pass the cast and 64 floats.");
  const ExactFloatingPoint exact;
  return take_cells(&cast->cast, cells, reason);
}

void sandglass_cast_get_texture(const sandglass_cast* cast, sandglass_texture* texture) {
  if (cast != nullptr && texture != nullptr) fill_texture(cast->cast, k_cast_light, texture);
}

void sandglass_cast_get_ambient(const sandglass_cast* cast, sandglass_texture* texture) {
  if (cast != nullptr && texture != nullptr) fill_texture(cast->cast, k_cast_ambient, texture);
}

void sandglass_cast_get_report(const sandglass_cast* cast, sandglass_cast_report* out) {
  if (cast == nullptr || out == nullptr) return;
  const CastTexture &light = cast->cast.targets[k_cast_light].front,
                    &ambient = cast->cast.targets[k_cast_ambient].front;
  sandglass_cast_report report = {};
  report.directions = light.directions;
  report.left_out = light.left_out > ambient.left_out ? light.left_out : ambient.left_out;
  report.too_far = light.too_far > ambient.too_far ? light.too_far : ambient.too_far;
  report.open = ambient.open;
  fill_struct(&report, sizeof report, out);
}
