// The triangles of all meshes in the plane's frame, cut at the plane, in arrays of corners: no index is followed while they
// are drawn. What is too far from the first mesh is taken out at the end: all share one rectangle of texels.
#include <cstring>

#include "runtime/math/finite.h"
#include "runtime/math/math.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr float k_near = 0.1f;             // metres; what is gathered is taken to be as large at least
constexpr uint32_t k_spike = 6;            // triangles, about as many as share a corner
constexpr uint32_t k_spike_share = 8;      // and at most one in so many
constexpr uint32_t k_restarts_most = 4;    // gatherings that other counts end, before a texture
constexpr uint32_t k_anchor_samples = 15;  // triangles of the first mesh
constexpr double k_finest_texel = 1e-5;    // metres
constexpr uint32_t k_unit_sifted = 4096;   // triangles in one unit

uint32_t group_of(const sandglass_cast_mesh& mesh) {
  const uint32_t first = mesh.is_real != 0 ? k_cast_real_closed : k_cast_virtual_closed;
  return mesh.closed != 0 ? first : first + 1;
}

void place(const CastFrame& frame, const float world_from_mesh[16], double rows[12]) {
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t column = 0; column < 4; ++column) {
      double sum = 0;
      for (uint32_t k = 0; k < 3; ++k) {
        const double entry = static_cast<double>(world_from_mesh[4 * column + k]);
        sum += frame.axes[axis][k] * (column == 3 ? entry - frame.origin[k] : entry);
      }
      rows[4 * axis + column] = sum;
    }
}

uint32_t index_at(const sandglass_cast_mesh& mesh, uint32_t i) {
  if (mesh.indices == nullptr) return i;
  if (mesh.index_bytes == 2) return static_cast<const uint16_t*>(mesh.indices)[i];
  return static_cast<const uint32_t*>(mesh.indices)[i];
}

// The first group that darkens the plane.
uint32_t first_dark(const CastState& c) {
  return c.gathered_frame.is_virtual ? k_cast_real_closed : k_cast_virtual_closed;
}

// How far a triangle's box begins and reaches from the anchor, in the largest of three coordinates.
void reach_of(const CastState& c, const float* const corners[3], float* nearest, float* farthest) {
  *nearest = *farthest = 0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    float low = k_cast_far, high = -k_cast_far;
    for (uint32_t i = 0; i < 3; ++i) {
      const float x = corners[i][axis] - c.anchor[axis];
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

void emit(CastState* c, const float* p, const float* q, const float* r) {
  if (c->kept == c->room) {
    ++c->left_out;
    return;
  }
  const float* const corners[3] = {p, q, r};
  for (uint32_t i = 0; i < 3; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) c->corners[3 * i + axis][c->kept] = corners[i][axis];
  ++c->kept;
  if (c->group < first_dark(*c)) return;
  float nearest, farthest;
  reach_of(*c, corners, &nearest, &farthest);
  CastReach* reach = &c->reaches[octave_of(farthest)];
  for (const float* corner : corners)
    for (uint32_t axis = 0; axis < 3; ++axis) {
      if (corner[axis] < reach->low[axis]) reach->low[axis] = corner[axis];
      if (corner[axis] > reach->high[axis]) reach->high[axis] = corner[axis];
    }
  if (nearest < reach->nearest) reach->nearest = nearest;
  if (farthest < reach->least) reach->least = farthest;
  ++reach->count;
  if (c->mesh == c->first_mesh) ++reach->first_mesh;
}

// What is above the plane, of something real above the bias: of a triangle that is cut, one triangle or two.
void emit_above(CastState* c, const float corners[3][3]) {
  const float level = c->group < k_cast_virtual_closed ? c->gathered_frame.bias : 0;
  float kept[4][3];
  uint32_t count = 0;
  for (uint32_t i = 0; i < 3; ++i) {
    const float *p = corners[i], *q = corners[i == 2 ? 0 : i + 1];
    if (p[1] > level) memcpy(kept[count++], p, sizeof kept[0]);
    if ((p[1] > level) == (q[1] > level)) continue;
    // From below to above, so that neighbours cut their common edge at the same place.
    const float *below = p[1] > level ? q : p, *above = p[1] > level ? p : q;
    const float t = (below[1] - level) / (below[1] - above[1]);
    kept[count][0] = below[0] + t * (above[0] - below[0]);
    kept[count][1] = level;
    kept[count][2] = below[2] + t * (above[2] - below[2]);
    ++count;
  }
  if (count >= 3) emit(c, kept[0], kept[1], kept[2]);
  if (count == 4) emit(c, kept[0], kept[2], kept[3]);
}

// Of the newest arrays: those that the mesh was begun with may be gone. False: an index that no vertex has, or a corner
// that is not finite or too far away.
bool corners_of(CastMesh* mesh, uint32_t triangle, const float rows[12], bool mirrored, float corners[3][3]) {
  const sandglass_cast_mesh& arrays = mesh->asked;
  for (uint32_t i = 0; i < 3; ++i) {
    const uint32_t index = index_at(arrays, 3 * triangle + i);
    if (index >= arrays.vertex_count) return false;
    const float* p = arrays.positions + uint64_t{index} * (arrays.stride / sizeof(float));
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

// Groups end at multiples of 16; what fills them up has no area.
void end_group(CastState* c) {
  for (; c->kept % k_lane_group != 0; ++c->kept)
    for (float* array : c->corners) array[c->kept] = 0;
  c->starts[++c->group] = c->kept;
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
void find_anchor(CastState* c) {
  for (c->first_mesh = 0; c->first_mesh < c->mesh_count; ++c->first_mesh) {
    CastMesh* mesh = &c->meshes[c->first_mesh];
    const uint32_t count = readable(*mesh);
    if (count == 0 || group_of(mesh->gathered) < first_dark(*c)) continue;
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
    for (uint32_t axis = 0; axis < 3; ++axis) c->anchor[axis] = places[axis][found / 2];
    return;
  }
}

// Takes what is near the first mesh together, octave by octave, until nothing is left that is near; and the box of it.
// False: something is too far.
bool take_near(CastState* c) {
  float size = k_near;
  uint32_t count = 0;
  for (uint32_t round = 0; round < k_cast_reaches; ++round)  // each takes one at least, or is the last
    for (CastReach& reach : c->reaches) {
      if (!reach.is_far) continue;
      const float most = c->reach * size;
      const bool spike = reach.least > most && reach.count <= k_spike && k_spike_share * reach.count <= count;
      if (c->reach > 0 && (spike || (reach.first_mesh == 0 && reach.nearest > most && count > 0))) continue;
      reach.is_far = false;
      count += reach.count;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const float away[2] = {c->anchor[axis] - reach.low[axis], reach.high[axis] - c->anchor[axis]};
        for (const float x : away) size = x > size ? x : size;
        const auto low = static_cast<double>(reach.low[axis]), high = static_cast<double>(reach.high[axis]);
        if (low < c->low[axis]) c->low[axis] = low;
        if (high > c->high[axis]) c->high[axis] = high;
      }
    }
  for (const CastReach& reach : c->reaches) c->too_far += reach.is_far ? reach.count : 0;
  return c->too_far == 0;
}

// Takes what is too far out of the gathered triangles.
bool sift(CastState* c) {
  for (uint32_t left = k_unit_sifted; c->group < k_cast_groups;) {
    if (c->cursor == c->starts[c->group + 1]) {
      end_group(c);
      continue;
    }
    if (left-- == 0) return false;
    const uint32_t at = c->cursor++;
    float corners[3][3], nearest, farthest;
    for (uint32_t i = 0; i < 9; ++i) corners[i / 3][i % 3] = c->corners[i][at];
    const float* const places[3] = {corners[0], corners[1], corners[2]};
    reach_of(*c, places, &nearest, &farthest);
    if (c->reaches[octave_of(farthest)].is_far) continue;
    for (float* array : c->corners) array[c->kept] = array[at];
    ++c->kept;
  }
  return true;
}

bool same_arrays(const sandglass_cast_mesh& a, const sandglass_cast_mesh& b) {
  return a.positions == b.positions && a.stride == b.stride && a.vertex_count == b.vertex_count &&
         a.indices == b.indices && a.index_bytes == b.index_bytes && a.triangle_count == b.triangle_count;
}

// The farthest that a corner of the mesh's box moves from where it was gathered, in texels of the finest texture. Where
// nothing is seen they have no size; rounding is less than the finest.
bool moved(const CastState& c, const CastMesh& mesh) {
  double now[12], texel = 0;
  place(c.frame, mesh.asked.world_from_mesh, now);
  for (const CastTarget& target : c.targets)
    for (const double side : target.front.texel)
      if (target.texels != 0 && side > 0 && (texel == 0 || side < texel)) texel = side;
  texel = texel > k_finest_texel ? texel : k_finest_texel;
  for (uint32_t corner = 0; corner < 8 && !(mesh.low[0] > mesh.high[0]); ++corner) {
    double way = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double *a = now + 4 * axis, *b = mesh.plane_from_mesh + 4 * axis;
      double move = a[3] - b[3];
      for (uint32_t k = 0; k < 3; ++k)
        move += (a[k] - b[k]) * static_cast<double>((corner >> k & 1) != 0 ? mesh.high[k] : mesh.low[k]);
      way += move * move;
    }
    if (!(way <= k_cast_still * k_cast_still * texel * texel)) return true;
  }
  return false;
}

// Whether a plane of another extent, as trackers make it from second to second, cuts a texture or did so before.
bool cut_otherwise(const CastState& c) {
  for (const CastTarget& target : c.targets)
    for (uint32_t axis = 0; axis < 2 && target.texels != 0; ++axis) {
      const double low[2] = {static_cast<double>(c.frame.low[axis]), static_cast<double>(c.gathered_frame.low[axis])};
      const double high[2] = {static_cast<double>(c.frame.high[axis]),
                              static_cast<double>(c.gathered_frame.high[axis])};
      const double texel = target.front.texel[axis], still = k_cast_still * texel;
      const double from = target.front.low[axis], to = from + texel * target.texels;
      if (absolute(low[0] - low[1]) > still && from <= (low[0] > low[1] ? low[0] : low[1]) + still) return true;
      if (absolute(high[0] - high[1]) > still && to >= (high[0] < high[1] ? high[0] : high[1]) - still) return true;
    }
  return false;
}

}  // namespace

void cast_compare(CastState* c) {
  bool other = false, counts = false, anew = false;
  uint32_t triangles = 0;
  for (uint32_t i = 0; i < c->mesh_count; ++i) {
    const CastMesh& mesh = c->meshes[i];
    triangles += mesh.asked.triangle_count;
    const uint32_t now = mesh.asked.triangle_count, before = mesh.gathered.triangle_count;
    counts = counts || now != before;
    anew = anew || (now > before ? now - before : before - now) > before / 4;
    other = other || !same_arrays(mesh.asked, mesh.gathered) || mesh.asked.version != mesh.gathered.version ||
            mesh.asked.closed != mesh.gathered.closed || mesh.asked.is_real != mesh.gathered.is_real || moved(*c, mesh);
  }
  const bool fewer = triangles < c->triangles;  // one may have gone
  counts = counts || triangles != c->triangles;
  anew = anew || (fewer && c->triangles - triangles > c->triangles / 4);
  c->triangles = triangles;
  const bool frame = c->frame.is_virtual != c->gathered_frame.is_virtual ||
                     absolute(static_cast<double>(c->frame.bias - c->gathered_frame.bias)) > 0 || cut_otherwise(*c);
  if (!other && !counts && !frame) return;
  c->stale = true;
  for (CastTarget& target : c->targets) target.asked = target.texels != 0;
  if (anew) c->targets[k_cast_light].draft = true;
  // Where the counts are as they were, it goes on in the new arrays: an engine may hand out other ones in every frame. And
  // after a few with other counts, too, in what both have: a scan grows in every frame.
  if (!counts || c->phase != CastPhase::gather || c->restarts == k_restarts_most) return;
  ++c->restarts;
  cast_begin_gather(c);
}

void cast_begin_gather(CastState* c) {
  c->phase = CastPhase::gather;
  c->group = c->mesh = c->cursor = c->kept = c->left_out = c->too_far = 0;
  c->sifts = false;
  c->first_mesh = c->mesh_count;
  for (float& x : c->anchor) x = 0;
  for (CastReach& reach : c->reaches) {
    reach = {{k_cast_far, k_cast_far, k_cast_far},
             {-k_cast_far, -k_cast_far, -k_cast_far},
             k_cast_far,
             k_cast_far,
             0,
             0,
             false};
  }
  c->gathered_frame = c->frame;
  c->stale = false;
  constexpr auto k_far = static_cast<double>(k_cast_far);
  for (uint32_t axis = 0; axis < 3; ++axis) {
    c->low[axis] = k_far;
    c->high[axis] = -k_far;
  }
  for (uint32_t i = 0; i < c->mesh_count; ++i) {
    CastMesh* mesh = &c->meshes[i];
    mesh->gathered = mesh->asked;
    place(c->frame, mesh->gathered.world_from_mesh, mesh->plane_from_mesh);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      mesh->low[axis] = k_cast_far;
      mesh->high[axis] = -k_cast_far;
    }
  }
}

bool cast_gather(CastState* c) {
  if (c->sifts) return sift(c);
  uint32_t left = k_cast_unit_triangles;
  if (c->first_mesh == c->mesh_count) find_anchor(c);
  while (c->group < k_cast_groups) {
    if (c->mesh >= c->mesh_count) {
      end_group(c);
      c->mesh = c->cursor = 0;
      continue;
    }
    CastMesh* mesh = &c->meshes[c->mesh];
    const uint32_t end = readable(*mesh);
    if (group_of(mesh->gathered) != c->group || c->cursor >= end) {
      ++c->mesh;
      c->cursor = 0;
      continue;
    }
    const Pose pose = pose_of(*mesh);
    for (; c->cursor < end && left > 0; ++c->cursor, --left) {
      float corners[3][3];
      if (corners_of(mesh, c->cursor, pose.rows, pose.mirrored, corners)) emit_above(c, corners);
      else ++c->left_out;
    }
    if (left == 0) return false;
  }
  for (CastReach& reach : c->reaches) reach.is_far = reach.count > 0;
  if (take_near(c)) return true;
  c->sifts = true;
  c->group = first_dark(*c);
  c->cursor = c->kept = c->starts[c->group];
  return false;
}

}  // namespace sandglass
