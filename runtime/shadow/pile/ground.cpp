// What the shadow falls on: the floor, and what stands on it as the app tells it, a map of heights. A texel then gets the
// shadow of its place on that, read between the middles of the map's cells.
#include "runtime/shadow/pile/pile.h"

#include <cstring>

#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"

namespace sandglass {
namespace {

constexpr float k_far = 1e4f;  // metres
constexpr uint32_t k_side_max = 256;
constexpr float k_same = 0.1f;  // texels: a tracked plane that moves its map by less moves no shadow

bool is_level(const sandglass_heights& map) {
  const float *a = map.along, *b = map.across;
  const double area =
      static_cast<double>(a[0]) * static_cast<double>(b[2]) - static_cast<double>(a[2]) * static_cast<double>(b[0]);
  return area * area > 1e-12;
}

sandglass_status check(const sandglass_heights& map, const char** reason) {
  if (map.struct_size != sizeof map)
    return refuse(reason, "heights.struct_size is not that of this library: set it to sizeof (sandglass_heights).");
  if (map.heights == nullptr || map.cells[0] < 2 || map.cells[1] < 2 || map.cells[0] > k_side_max ||
      map.cells[1] > k_side_max)
    return refuse(reason, "heights has no array, or not 2 to 256 cells along a side.");
  for (uint32_t k = 0; k < 3; ++k)
    if (!within(map.corner[k], -k_far, k_far) || !within(map.along[k], -k_far, k_far) ||
        !within(map.across[k], -k_far, k_far) || !within(map.up[k], -1.001f, 1.001f))
      return refuse(reason, "heights.corner, along, across or up is not finite, or beyond 10 km.");
  if (!is_level(map))
    return refuse(reason, "heights.along and across are upright, or along each other: no floor is like that.");
  return accept(reason);
}

// Where the map lies, as seen from the rectangle.
void place(PileGround* ground, const PileRectangle& r) {
  const sandglass_heights& map = ground->map;
  const float *a = map.along, *b = map.across;
  const float inverse = 1 / (a[0] * b[2] - a[2] * b[0]);
  const float sides[2] = {static_cast<float>(map.cells[0]), static_cast<float>(map.cells[1])};
  const float per_metre[2][2] = {{b[2] * inverse * sides[0], -b[0] * inverse * sides[0]},
                                 {-a[2] * inverse * sides[1], a[0] * inverse * sides[1]}};
  for (uint32_t axis = 0; axis < 2; ++axis) {
    for (uint32_t k = 0; k < 2; ++k) ground->per_texel[axis][k] = per_metre[axis][k] * r.texel[k];
    ground->first[axis] =
        per_metre[axis][0] * (r.low[0] - map.corner[0]) + per_metre[axis][1] * (r.low[1] - map.corner[2]) - 0.5f;
    const float* edge = axis == 0 ? a : b;
    ground->rise[axis] = edge[1] / sides[axis];
  }
  ground->foot = map.corner[1] - r.height;
  ground->highest = 0;
  const uint32_t count = map.cells[0] * map.cells[1];
  const float lifts = __builtin_fabsf(a[1]) + __builtin_fabsf(b[1]) + (ground->foot > 0 ? ground->foot : 0);
  for (uint32_t i = 0; i < count; ++i) {
    const float h = map.heights[i] + lifts;
    ground->highest = h > ground->highest && h < k_far ? h : ground->highest;
  }
}

}  // namespace

float ground_at(const PileGround& ground, float column, float row) {
  if (ground.map.heights == nullptr) return 0;
  float share[2];
  uint32_t cell[2];
  for (uint32_t axis = 0; axis < 2; ++axis) {
    const float at = ground.first[axis] + ground.per_texel[axis][0] * column + ground.per_texel[axis][1] * row;
    const uint32_t last = ground.map.cells[axis] - 1;
    if (!(at >= -0.5f && at <= static_cast<float>(last) + 0.5f)) return 0;
    const float in = at > 0 ? at : 0;
    cell[axis] = static_cast<uint32_t>(in) < last ? static_cast<uint32_t>(in) : last - 1;
    share[axis] = in - static_cast<float>(cell[axis]);
    share[axis] = share[axis] < 1 ? share[axis] : 1;
  }
  const float *low = ground.map.heights + uint64_t{cell[1]} * ground.map.cells[0] + cell[0],
              *high = low + ground.map.cells[0];
  const float near = low[0] + share[0] * (low[1] - low[0]), far = high[0] + share[0] * (high[1] - high[0]);
  float height = ground.foot + (near + share[1] * (far - near)) * ground.map.up[1];
  for (uint32_t axis = 0; axis < 2; ++axis)
    height += ground.rise[axis] * (static_cast<float>(cell[axis]) + share[axis] + 0.5f);
  return height > 0 && height < k_far ? height : 0;
}

void ground_row(const PileGround& ground, uint32_t row, uint32_t texels, uint32_t joined, float* heights) {
  if (ground.map.heights == nullptr) {
    memset(heights, 0, texels * sizeof *heights);
    return;
  }
  const float side = static_cast<float>(joined), z = (static_cast<float>(row) + 0.5f) * side;
  for (uint32_t u = 0; u < texels; ++u) heights[u] = ground_at(ground, (static_cast<float>(u) + 0.5f) * side, z);
}

sandglass_status ground_take(PileGround* ground, const PileRectangle& rectangle, const sandglass_heights& map,
                             bool* changed, const char** reason) {
  if (const sandglass_status status = check(map, reason)) return status;
  const sandglass_heights& was = ground->map;
  *changed = was.heights != map.heights || was.version != map.version || was.cells[0] != map.cells[0] ||
             was.cells[1] != map.cells[1];
  const float same = k_same * (rectangle.texel[0] < rectangle.texel[1] ? rectangle.texel[0] : rectangle.texel[1]);
  const auto moves = [same](float from, float to) { return __builtin_fabsf(to - from) > same; };
  for (uint32_t k = 0; k < 3; ++k)
    *changed = *changed || moves(was.corner[k], map.corner[k]) || moves(was.along[k], map.along[k]) ||
               moves(was.across[k], map.across[k]);
  if (!*changed) return accept(reason);
  ground->map = map;
  place(ground, rectangle);
  return accept(reason);
}

}  // namespace sandglass
