// The triangles of all meshes in the plane's frame, cut at the plane, in arrays of corners: no index is followed while
// they are drawn. What is too far from the first mesh is taken out at the end: all share one rectangle of texels.
#include <cstring>

#include "runtime/math/app_mesh.h"
#include "runtime/math/math.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr float k_near = 0.1f;             // metres; what is gathered is taken to be as large at least
constexpr uint32_t k_spike = 6;            // triangles, about as many as share a corner
constexpr uint32_t k_spike_share = 8;      // and at most one in so many
constexpr uint32_t k_anchor_samples = 15;  // triangles of the first mesh
constexpr uint32_t k_unit_sifted = 4096;   // triangles in one unit

uint32_t group_of(const sandglass_cast_mesh& mesh) {
  const uint32_t first = mesh.is_real != 0 ? k_cast_real_closed : k_cast_virtual_closed;
  return mesh.closed != 0 ? first : first + 1;
}

// The first part of what darkens the plane.
uint32_t first_dark(const CastGathered& g) {
  return g.layers * (g.frame.is_virtual ? k_cast_real_closed : k_cast_virtual_closed);
}

// How far a triangle's box begins and reaches from the anchor, in the largest of three coordinates.
void reach_of(const float anchor[3], const float* const corners[3], float* nearest, float* farthest) {
  *nearest = *farthest = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    float low = k_cast_far, high = -k_cast_far;
    for (uint32_t i = 0; i < 3; ++i) {
      const float x = corners[i][axis] - anchor[axis];
      low = x < low ? x : low;
      high = x > high ? x : high;
    }
    const float away = low > 0 ? low : -high, far = -low > high ? -low : high;
    *nearest = away > *nearest ? away : *nearest;
    *farthest = far > *farthest ? far : *farthest;
  }
}

uint32_t octave_of(float reach) {
  constexpr uint32_t k_lowest = 127 - 16;
  uint32_t bits;
  memcpy(&bits, &reach, sizeof bits);
  const uint32_t exponent = bits >> 23;
  return exponent < k_lowest ? 0 : exponent - k_lowest < k_cast_reaches ? exponent - k_lowest : k_cast_reaches - 1;
}

void emit(CastGathered* g, const float* p, const float* q, const float* r) {
  if (g->kept == g->room) {
    ++g->left_out;
    return;
  }
  const float* const corners[3] = {p, q, r};
  for (uint32_t i = 0; i < 3; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) g->corners[3 * i + axis][g->kept] = corners[i][axis];
  ++g->kept;
  if (g->part < first_dark(*g)) return;
  float nearest, farthest;
  reach_of(g->anchor, corners, &nearest, &farthest);
  CastReach* reach = &g->reaches[octave_of(farthest)];
  for (const float* corner : corners)
    for (uint32_t axis = 0; axis < 3; ++axis) {
      if (corner[axis] < reach->low[axis]) reach->low[axis] = corner[axis];
      if (corner[axis] > reach->high[axis]) reach->high[axis] = corner[axis];
    }
  if (nearest < reach->nearest) reach->nearest = nearest;
  if (farthest < reach->farthest_min) reach->farthest_min = farthest;
  ++reach->count;
  if (g->mesh == g->first_mesh) ++reach->first_mesh;
}

// Of a triangle, and of what two cuts leave of it.
struct Outline {
  float corners[5][3];
  uint32_t count = 0;
};

// What of an outline is above a level, or what is not.
Outline cut(const Outline& outline, float level, bool above_it) {
  Outline kept;
  for (uint32_t i = 0; i < outline.count; ++i) {
    const float *p = outline.corners[i], *q = outline.corners[i + 1 == outline.count ? 0 : i + 1];
    if ((p[1] > level) == above_it) memcpy(kept.corners[kept.count++], p, sizeof kept.corners[0]);
    if ((p[1] > level) == (q[1] > level)) continue;
    // From below to above, so that neighbours cut their common edge at the same place.
    const float *below = p[1] > level ? q : p, *above = p[1] > level ? p : q;
    const float t = (below[1] - level) / (below[1] - above[1]);
    float* at = kept.corners[kept.count++];
    at[0] = below[0] + t * (above[0] - below[0]);
    at[1] = level;
    at[2] = below[2] + t * (above[2] - below[2]);
  }
  return kept;
}

// What of a triangle is between a layer and the next; of something real, both are higher by the bias.
void emit_part(CastGathered* g, const float corners[3][3]) {
  const uint32_t layer = g->part % g->layers;
  const float bias = g->part < k_cast_virtual_closed * g->layers ? g->frame.bias : 0;
  const float bottom = cast_level(g->frame, g->layers, layer) + bias;
  const float top = layer + 1 < g->layers ? cast_level(g->frame, g->layers, layer + 1) + bias : k_cast_far;
  uint32_t above = 0, beyond = 0;
  for (uint32_t i = 0; i < 3; ++i) {
    above += corners[i][1] > bottom ? 1 : 0;
    beyond += corners[i][1] > top ? 1 : 0;
  }
  if (above == 0 || beyond == 3) return;
  if (above == 3 && beyond == 0) return emit(g, corners[0], corners[1], corners[2]);
  Outline kept;
  kept.count = 3;
  memcpy(kept.corners, corners, 3 * sizeof kept.corners[0]);
  if (above < 3) kept = cut(kept, bottom, true);
  if (beyond > 0) kept = cut(kept, top, false);
  for (uint32_t i = 2; i < kept.count; ++i) emit(g, kept.corners[0], kept.corners[i - 1], kept.corners[i]);
}

// Reads from the newest arrays, because the app may have freed those that the mesh was begun with. False: an index that
// no vertex has, or a corner that is not finite or too far away.
bool corners_of(CastMesh* mesh, uint32_t triangle, const float rows[12], bool mirrored, float corners[3][3]) {
  for (uint32_t i = 0; i < 3; ++i) {
    const float* p = mesh_corner(mesh->asked, 3ull * triangle + i);
    if (p == nullptr) return false;
    float* out = corners[mirrored && i != 0 ? 3 - i : i];
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const float* row = rows + 4 * axis;
      out[axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
      if (!within(out[axis], -k_cast_far, k_cast_far)) return false;
      if (p[axis] < mesh->low[axis]) mesh->low[axis] = p[axis];
      if (p[axis] > mesh->high[axis]) mesh->high[axis] = p[axis];
    }
  }
  return true;
}

// How many triangles of a mesh are gathered: those that it had when that began, and has yet.
uint32_t readable(const CastMesh& mesh) {
  const uint32_t now = mesh.asked.triangle_count, then = mesh.gathered.triangle_count;
  return now < then ? now : then;
}

// Parts end at multiples of 16; what fills them up has no area.
void end_part(CastGathered* g) {
  for (; g->kept % k_lane_group != 0; ++g->kept)
    for (float* array : g->corners) array[g->kept] = 0;
  g->starts[++g->part] = g->kept;
}

// A mesh's pose, and whether it mirrors.
struct Pose {
  float rows[12];
  bool mirrored;
};
Pose pose_of(const CastMesh& mesh) {
  const double* m = mesh.plane_from_mesh;
  Pose pose;
  for (uint32_t i = 0; i < 12; ++i) pose.rows[i] = static_cast<float>(m[i]);
  pose.mirrored =
      m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]) <
      0;
  return pose;
}

// The middle of the first mesh that darkens the plane: the median of a few of its triangles, which one bad corner does
// not move.
void find_anchor(CastGathered* g, CastMesh* meshes, uint32_t mesh_count) {
  for (g->first_mesh = 0; g->first_mesh < mesh_count; ++g->first_mesh) {
    CastMesh* mesh = &meshes[g->first_mesh];
    const uint32_t count = readable(*mesh);
    if (count == 0 || g->layers * group_of(mesh->gathered) < first_dark(*g)) continue;
    const Pose pose = pose_of(*mesh);
    float places[3][3 * k_anchor_samples];
    uint32_t found = 0;
    for (uint32_t i = 0; i < k_anchor_samples; ++i) {
      float corners[3][3];
      const auto triangle = static_cast<uint32_t>(uint64_t{i} * count / k_anchor_samples);
      if (!corners_of(mesh, triangle, pose.rows, pose.mirrored, corners)) continue;
      for (uint32_t corner = 0; corner < 3; ++corner, ++found)
        for (uint32_t axis = 0; axis < 3; ++axis) {  // in order
          uint32_t at = found;
          for (; at > 0 && places[axis][at - 1] > corners[corner][axis]; --at) places[axis][at] = places[axis][at - 1];
          places[axis][at] = corners[corner][axis];
        }
    }
    if (found == 0) continue;
    for (uint32_t axis = 0; axis < 3; ++axis) g->anchor[axis] = places[axis][found / 2];
    return;
  }
}

// Takes what is near the first mesh together, octave by octave, until nothing is left that is near; and the box of it.
// `farthest`: sizes that it may be away, or 0. False: something is too far.
bool take_near(CastGathered* g, float farthest) {
  float size = k_near;
  uint32_t count = 0;
  const uint32_t spike_max = g->layers > 1 ? 2 * k_spike : k_spike;  // what is above the highest layer may count twice
  for (uint32_t round = 0; round < k_cast_reaches; ++round)          // each takes one at least, or is the last
    for (CastReach& reach : g->reaches) {
      if (!reach.is_far) continue;
      const float limit = farthest * size;
      const bool spike = reach.farthest_min > limit && reach.count <= spike_max && k_spike_share * reach.count <= count;
      if (farthest > 0 && (spike || (reach.first_mesh == 0 && reach.nearest > limit && count > 0))) continue;
      reach.is_far = false;
      count += reach.count;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const float away[2] = {g->anchor[axis] - reach.low[axis], reach.high[axis] - g->anchor[axis]};
        for (const float x : away) size = x > size ? x : size;
        const auto low = static_cast<double>(reach.low[axis]), high = static_cast<double>(reach.high[axis]);
        if (low < g->low[axis]) g->low[axis] = low;
        if (high > g->high[axis]) g->high[axis] = high;
      }
    }
  g->darkens = count > 0;
  for (uint32_t axis = 0; axis < 3 && !g->darkens; ++axis) g->low[axis] = g->high[axis] = 0;
  for (const CastReach& reach : g->reaches) g->too_far += reach.is_far ? reach.count : 0;
  return g->too_far == 0;
}

// Takes what is too far out of the gathered triangles.
bool sift(CastGathered* g) {
  for (uint32_t left = k_unit_sifted; g->part < k_cast_groups * g->layers;) {
    if (g->triangle == g->starts[g->part + 1]) {
      end_part(g);
      continue;
    }
    if (left-- == 0) return false;
    const uint32_t at = g->triangle++;
    float corners[3][3], nearest, farthest;
    for (uint32_t i = 0; i < 9; ++i) corners[i / 3][i % 3] = g->corners[i][at];
    const float* const places[3] = {corners[0], corners[1], corners[2]};
    reach_of(g->anchor, places, &nearest, &farthest);
    if (g->reaches[octave_of(farthest)].is_far) continue;
    for (float* array : g->corners) array[g->kept] = array[at];
    ++g->kept;
  }
  return true;
}

}  // namespace

void cast_place(const CastFrame& frame, const float world_from_mesh[16], double rows[12]) {
  place_mesh(frame.axes, frame.origin, world_from_mesh, rows);
}

void cast_begin_gather(CastGathered* g, CastMesh* meshes, const CastRequest& request) {
  g->part = g->mesh = g->triangle = g->kept = g->left_out = g->too_far = 0;
  g->sifts = false;
  g->first_mesh = request.mesh_count;
  for (float& x : g->anchor) x = 0;
  for (CastReach& reach : g->reaches) {
    reach = {{k_cast_far, k_cast_far, k_cast_far},
             {-k_cast_far, -k_cast_far, -k_cast_far},
             k_cast_far,
             k_cast_far,
             0,
             0,
             false};
  }
  g->frame = request.frame;
  constexpr auto k_far = static_cast<double>(k_cast_far);
  for (uint32_t axis = 0; axis < 3; ++axis) {
    g->low[axis] = k_far;
    g->high[axis] = -k_far;
  }
  for (uint32_t i = 0; i < request.mesh_count; ++i) {
    CastMesh* mesh = &meshes[i];
    mesh->gathered = mesh->asked;
    cast_place(request.frame, mesh->gathered.world_from_mesh, mesh->plane_from_mesh);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      mesh->low[axis] = k_cast_far;
      mesh->high[axis] = -k_cast_far;
    }
  }
}

bool cast_gather(CastGathered* g, CastMesh* meshes, uint32_t mesh_count, float farthest) {
  if (g->sifts) return sift(g);
  uint32_t left = k_cast_unit_triangles;
  if (g->first_mesh == mesh_count) find_anchor(g, meshes, mesh_count);
  while (g->part < k_cast_groups * g->layers) {
    if (g->mesh >= mesh_count) {
      end_part(g);
      g->mesh = g->triangle = 0;
      continue;
    }
    CastMesh* mesh = &meshes[g->mesh];
    const uint32_t end = readable(*mesh);
    if (group_of(mesh->gathered) != g->part / g->layers || g->triangle >= end) {
      ++g->mesh;
      g->triangle = 0;
      continue;
    }
    const Pose pose = pose_of(*mesh);
    for (; g->triangle < end && left > 0; ++g->triangle, --left) {
      float corners[3][3];
      if (corners_of(mesh, g->triangle, pose.rows, pose.mirrored, corners)) emit_part(g, corners);
      else if (g->part % g->layers == 0) ++g->left_out;
    }
    if (left == 0) return false;
  }
  for (CastReach& reach : g->reaches) reach.is_far = reach.count > 0;
  if (take_near(g, farthest)) return true;
  g->sifts = true;
  g->part = first_dark(*g);
  g->triangle = g->kept = g->starts[g->part];
  return false;
}

}  // namespace sandglass
