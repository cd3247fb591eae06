// The triangles of all meshes in the plane's frame, cut at the plane, in arrays of corners: no index is followed while they
// are drawn.
#include <cstring>

#include "runtime/cast/cast.h"
#include "runtime/core/finite.h"

namespace sandglass {
namespace {

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

void emit(CastState* c, const float* p, const float* q, const float* r) {
  if (c->kept == c->room) {
    ++c->left_out;
    return;
  }
  const float* const corners[3] = {p, q, r};
  for (uint32_t i = 0; i < 3; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis) c->corners[3 * i + axis][c->kept] = corners[i][axis];
  ++c->kept;
  if (c->group < k_cast_virtual_closed && !c->gathered_frame.is_virtual) return;
  for (const float* corner : corners)
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double x = static_cast<double>(corner[axis]);
      if (x < c->low[axis]) c->low[axis] = x;
      if (x > c->high[axis]) c->high[axis] = x;
    }
}

// What is above the plane: of a triangle that it cuts, one triangle or two.
void emit_above(CastState* c, const float corners[3][3]) {
  float kept[4][3];
  uint32_t count = 0;
  for (uint32_t i = 0; i < 3; ++i) {
    const float *p = corners[i], *q = corners[i == 2 ? 0 : i + 1];
    if (p[1] > 0) memcpy(kept[count++], p, sizeof kept[0]);
    if ((p[1] > 0) == (q[1] > 0)) continue;
    // From below to above, so that neighbours cut their common edge at the same place.
    const float *below = p[1] > 0 ? q : p, *above = p[1] > 0 ? p : q;
    const float t = below[1] / (below[1] - above[1]);
    kept[count][0] = below[0] + t * (above[0] - below[0]);
    kept[count][1] = 0;
    kept[count][2] = below[2] + t * (above[2] - below[2]);
    ++count;
  }
  if (count >= 3) emit(c, kept[0], kept[1], kept[2]);
  if (count == 4) emit(c, kept[0], kept[2], kept[3]);
}

// False: an index that no vertex has, or a corner that is not finite or too far away.
bool corners_of(CastMesh* mesh, uint32_t triangle, const float rows[12], bool mirrored, float corners[3][3]) {
  for (uint32_t i = 0; i < 3; ++i) {
    const uint32_t index = index_at(mesh->gathered, 3 * triangle + i);
    if (index >= mesh->gathered.vertex_count) return false;
    const float* p = mesh->gathered.positions + uint64_t{index} * (mesh->gathered.stride / sizeof(float));
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

// Groups end at multiples of 16; what fills them up has no area.
void end_group(CastState* c) {
  for (; c->kept % k_lane_group != 0; ++c->kept)
    for (float* array : c->corners) array[c->kept] = 0;
  c->starts[++c->group] = c->kept;
  c->mesh = c->cursor = 0;
}

bool same_arrays(const sandglass_cast_mesh& a, const sandglass_cast_mesh& b) {
  return a.positions == b.positions && a.stride == b.stride && a.vertex_count == b.vertex_count &&
         a.indices == b.indices && a.index_bytes == b.index_bytes && a.triangle_count == b.triangle_count;
}

// The farthest that a corner of the mesh's box moves from where it was gathered, in texels of the finest texture.
bool moved(const CastState& c, const CastMesh& mesh) {
  double now[12], texel = 0;
  place(c.frame, mesh.asked.world_from_mesh, now);
  for (const CastTarget& target : c.targets)
    for (const double side : target.front.texel)
      if (target.texels != 0 && (texel == 0 || side < texel)) texel = side;
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
  bool cuts = false, same = true;
  for (uint32_t axis = 0; axis < 2; ++axis) {
    same = same && c.frame.low[axis] == c.gathered_frame.low[axis] && c.frame.high[axis] == c.gathered_frame.high[axis];
    const float least = c.frame.low[axis] > c.gathered_frame.low[axis] ? c.frame.low[axis] : c.gathered_frame.low[axis];
    const float most =
        c.frame.high[axis] < c.gathered_frame.high[axis] ? c.frame.high[axis] : c.gathered_frame.high[axis];
    for (const CastTarget& target : c.targets) {
      const CastTexture& front = target.front;
      const double end = front.low[axis] + front.texel[axis] * target.texels;
      cuts = cuts ||
             (target.texels != 0 && (front.low[axis] < static_cast<double>(least) || end > static_cast<double>(most)));
    }
  }
  return !same && cuts;
}

}  // namespace

void cast_compare(CastState* c) {
  bool other = false, arrays = false;
  uint32_t triangles = 0;
  for (uint32_t i = 0; i < c->mesh_count; ++i) {
    const CastMesh& mesh = c->meshes[i];
    triangles += mesh.asked.triangle_count;
    const bool same = same_arrays(mesh.asked, mesh.gathered);
    arrays = arrays || !same;
    other = other || !same || mesh.asked.version != mesh.gathered.version ||
            mesh.asked.closed != mesh.gathered.closed || mesh.asked.is_real != mesh.gathered.is_real || moved(*c, mesh);
  }
  arrays = arrays || triangles != c->triangles;
  c->triangles = triangles;
  const bool frame = c->frame.is_virtual != c->gathered_frame.is_virtual || cut_otherwise(*c);
  if (!other && !arrays && !frame) return;
  c->stale = true;
  for (CastTarget& target : c->targets) target.asked = target.texels != 0;
  if (arrays) c->targets[k_cast_light].draft = true;
  if (arrays && c->phase == CastPhase::gather) cast_begin_gather(c);
}

void cast_begin_gather(CastState* c) {
  c->phase = CastPhase::gather;
  c->group = c->mesh = c->cursor = c->kept = c->left_out = 0;
  c->gathered_frame = c->frame;
  c->stale = false;
  constexpr auto k_far = static_cast<double>(k_cast_far);
  for (uint32_t axis = 0; axis < 3; ++axis) c->low[axis] = k_far, c->high[axis] = -k_far;
  for (uint32_t i = 0; i < c->mesh_count; ++i) {
    CastMesh* mesh = &c->meshes[i];
    mesh->gathered = mesh->asked;
    place(c->frame, mesh->gathered.world_from_mesh, mesh->plane_from_mesh);
    for (uint32_t axis = 0; axis < 3; ++axis) mesh->low[axis] = k_cast_far, mesh->high[axis] = -k_cast_far;
  }
}

bool cast_gather(CastState* c) {
  uint32_t left = k_cast_unit_triangles;
  while (c->group < k_cast_groups) {
    if (c->mesh == c->mesh_count) {
      end_group(c);
      continue;
    }
    CastMesh* mesh = &c->meshes[c->mesh];
    if (group_of(mesh->gathered) != c->group || c->cursor == mesh->gathered.triangle_count) {
      ++c->mesh;
      c->cursor = 0;
      continue;
    }
    float rows[12];
    for (uint32_t i = 0; i < 12; ++i) rows[i] = static_cast<float>(mesh->plane_from_mesh[i]);
    const double* m = mesh->plane_from_mesh;
    const bool mirrored =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]) <
        0;
    for (; c->cursor < mesh->gathered.triangle_count && left > 0; ++c->cursor, --left) {
      float corners[3][3];
      if (corners_of(mesh, c->cursor, rows, mirrored, corners)) emit_above(c, corners);
      else ++c->left_out;
    }
    if (left == 0) return false;
  }
  return true;
}

}  // namespace sandglass
