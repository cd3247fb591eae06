// Heights from triangles: of each column the highest surface below the ceiling. Two passes, in units: raise writes the
// triangles of all meshes into an array beside the heights; settle compares that with what meshes gave before, and sets the
// cells where it differs. So a mesh that goes takes its heights along, and what depth images have changed since stays.
#include "kernels/whole.h"
#include "platform/floating_point.h"
#include "runtime/frame/refuse.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr uint32_t k_unit_cells = 4096;  // that triangles may cover, in one unit
constexpr uint32_t k_restarts_max = 4;   // of a raise under which meshes change
// Of a cell: a middle so near an edge is within both triangles, so that it is never within neither.
constexpr float k_edge = 1e-3f;
constexpr float k_upright = 1e-3f;  // cells; a triangle that covers less is upright, and has no top
constexpr double k_still = 0.002;   // metres; what moves less is where it was

// From a mesh's frame into the plane's.
void find_rows(const ReliefState& relief, const float world_from_mesh[16], double rows[12]) {
  Rotation plane = {};
  rotation_of(relief.rotation, &plane);
  double axes[3][3], origin[3];
  for (int k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) axes[axis][k] = plane.m[k][axis];
    origin[k] = static_cast<double>(relief.position[k]);
  }
  place_mesh(axes, origin, world_from_mesh, rows);
}

bool has_moved(const ReliefState& relief, const ReliefMesh& mesh) {
  double now[12];
  find_rows(relief, mesh.asked.world_from_mesh, now);
  for (int axis = 0; axis < 3; ++axis) {
    const double *a = now + 4 * axis, *b = mesh.rows + 4 * axis;
    double move = __builtin_fabs(a[3] - b[3]);
    for (int k = 0; k < 3; ++k) move += mesh.reach * __builtin_fabs(a[k] - b[k]);
    if (!(move <= k_still)) return true;
  }
  return false;
}

// A triangle above the map: x and z in cells, y in metres.
struct Raised {
  float x[3], y[3], z[3];
};

// False: it has a corner that is none, or lies beside the map, above the ceiling or below the plane.
bool find_corners(const ReliefState& relief, ReliefMesh* mesh, uint32_t triangle, Raised* t) {
  float low[3] = {k_mesh_far, k_mesh_far, k_mesh_far}, high[3] = {-k_mesh_far, -k_mesh_far, -k_mesh_far};
  double reach = 0;
  for (uint32_t i = 0; i < 3; ++i) {
    const float* p = mesh_corner(mesh->asked, 3ull * triangle + i);
    if (p == nullptr || !all_within(p, 3, -k_mesh_far, k_mesh_far)) return false;
    double at[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double* row = mesh->rows + 4 * axis;
      at[axis] = row[3];
      for (int k = 0; k < 3; ++k) at[axis] += row[k] * static_cast<double>(p[k]);
      const double size = __builtin_fabs(static_cast<double>(p[axis]));
      reach = size > reach ? size : reach;
    }
    const auto per_metre = static_cast<double>(relief.per_metre);
    t->x[i] = static_cast<float>(at[0] * per_metre) + relief.middle[0];
    t->y[i] = static_cast<float>(at[1]);
    t->z[i] = static_cast<float>(at[2] * per_metre) + relief.middle[1];
    const float corner[3] = {t->x[i], t->y[i], t->z[i]};
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = corner[axis] < low[axis] ? corner[axis] : low[axis];
      high[axis] = corner[axis] > high[axis] ? corner[axis] : high[axis];
    }
  }
  const float end[2] = {static_cast<float>(relief.desc.cells[0]), static_cast<float>(relief.desc.cells[1])};
  if (!(high[0] > 0 && high[2] > 0 && low[0] < end[0] && low[2] < end[1])) return false;
  if (low[1] > relief.desc.ceiling || high[1] < k_relief_lowest * k_relief_unit) return false;
  mesh->reach = reach > mesh->reach ? reach : mesh->reach;
  return true;
}

// The middles of cells from low to high: the first, and the one after the last.
void middles_within(const float corners[3], uint32_t cells, uint32_t range[2]) {
  float low = corners[0], high = corners[0];
  for (int i = 1; i < 3; ++i) {
    low = corners[i] < low ? corners[i] : low;
    high = corners[i] > high ? corners[i] : high;
  }
  low -= 0.5f + k_edge;
  high += 0.5f + k_edge;
  const auto end = static_cast<float>(cells);
  range[0] = low > 0 ? to_whole<uint32_t>(low < end ? low : end) : 0;
  range[1] = high > 0 ? to_whole<uint32_t>(high < end ? high : end) : 0;
}

void raise_cell(const ReliefState& relief, uint32_t cell, float height) {
  if (height > relief.desc.ceiling) return;
  int32_t whole = floor_whole(height * k_relief_per_metre + 0.5f);
  if (whole < k_relief_lowest) return;
  if (whole < k_relief_flat && whole > -k_relief_flat) whole = 0;
  whole = whole < k_relief_highest ? whole : k_relief_highest;
  int16_t* made = &relief.raised.made[cell];
  if (whole > *made) *made = static_cast<int16_t>(whole);
}

// The rows of a triangle from `row` on, while there are cells left. Returns whether they are done.
bool raise_rows(const ReliefState& relief, const Raised& t, uint32_t* row, uint32_t* left) {
  const float ax = t.x[1] - t.x[0], az = t.z[1] - t.z[0], bx = t.x[2] - t.x[0], bz = t.z[2] - t.z[0];
  const float area = ax * bz - bx * az, ay = t.y[1] - t.y[0], by = t.y[2] - t.y[0];
  float low = t.y[0], high = t.y[0];
  for (int i = 1; i < 3; ++i) {
    low = t.y[i] < low ? t.y[i] : low;
    high = t.y[i] > high ? t.y[i] : high;
  }
  if (!(area > k_upright || area < -k_upright)) return true;
  const float slope_x = (ay * bz - by * az) / area, slope_z = (by * ax - ay * bx) / area,
              side = area > 0 ? 1.0f : -1.0f;
  uint32_t columns[2], rows[2];
  middles_within(t.x, relief.desc.cells[0], columns);
  middles_within(t.z, relief.desc.cells[1], rows);
  const uint32_t width = columns[1] > columns[0] ? columns[1] - columns[0] : 0;
  for (*row += *row < rows[0] ? rows[0] - *row : 0; *row < rows[1]; ++*row) {
    if (*left < width) return false;
    *left -= width;
    const float z = static_cast<float>(*row) + 0.5f;
    for (uint32_t column = columns[0]; column < columns[1]; ++column) {
      const float x = static_cast<float>(column) + 0.5f;
      bool within_all = true;
      for (int i = 0, j = 2; i < 3; j = i++) {
        const float ex = t.x[i] - t.x[j], ez = t.z[i] - t.z[j];
        const float beside = side * (ex * (z - t.z[j]) - ez * (x - t.x[j]));
        within_all &= beside >= -k_edge * (__builtin_fabsf(ex) + __builtin_fabsf(ez));
      }
      if (!within_all) continue;
      const float y = t.y[0] + (x - t.x[0]) * slope_x + (z - t.z[0]) * slope_z;
      raise_cell(relief, *row * relief.desc.cells[0] + column, y < low ? low : (y > high ? high : y));
    }
  }
  return true;
}

void begin_raise(ReliefState* relief) {
  ReliefRaised* r = &relief->raised;
  r->due = false;
  r->mesh = r->triangle = r->row = 0;
  for (uint32_t i = 0; i < r->count; ++i) {
    find_rows(*relief, r->meshes[i].asked.world_from_mesh, r->meshes[i].rows);
    r->meshes[i].reach = 0;
  }
  const uint32_t cells = relief_cells(*relief);
  for (uint32_t i = 0; i < cells; ++i) r->made[i] = k_relief_none;
}

}  // namespace

void relief_meshes_moved(ReliefState* relief) {
  ReliefRaised* r = &relief->raised;
  for (uint32_t i = 0; i < r->count && !r->due; ++i) r->due = has_moved(*relief, r->meshes[i]);
}

void relief_begin_raise(ReliefState* relief) {
  begin_raise(relief);
  relief->raised.restarts = 0;
  relief->phase = ReliefPhase::raise;
  relief->cursor = 0;
}

uint32_t relief_raise_items(const ReliefState& relief) {
  const ReliefRaised& r = relief.raised;
  uint32_t left = 0;
  for (uint32_t i = r.mesh; i < r.count; ++i) left += r.meshes[i].asked.triangle_count;
  return left > r.triangle ? left - r.triangle : 0;
}

bool relief_raise(ReliefState* relief) {
  ReliefRaised* r = &relief->raised;
  uint32_t triangles = k_relief_unit_triangles, cells = k_unit_cells;
  for (; r->mesh < r->count; ++r->mesh, r->triangle = r->row = 0) {
    ReliefMesh* mesh = &r->meshes[r->mesh];
    for (; r->triangle < mesh->asked.triangle_count; ++r->triangle, r->row = 0) {
      Raised t;
      if (triangles-- == 0) return false;
      if (find_corners(*relief, mesh, r->triangle, &t) && !raise_rows(*relief, t, &r->row, &cells)) return false;
    }
  }
  if (!r->due || r->restarts++ == k_restarts_max) return true;
  begin_raise(relief);
  return false;
}

void relief_settle(ReliefState* relief, uint32_t first, uint32_t end) {
  const ReliefRaised& r = relief->raised;
  for (uint32_t i = first; i < end; ++i) {
    if (r.made[i] == r.given[i]) continue;
    r.given[i] = r.made[i];
    const int16_t height = r.made[i] == k_relief_none ? 0 : r.made[i];
    if (height != relief->cells.shown[i]) relief_version_takes(relief, i);
    relief_set_cell(relief, i, height);
  }
}

// Out of line: it runs between the two calls that set and restore the floating-point control.
__attribute__((noinline)) static sandglass_status take_meshes(ReliefState* relief, const sandglass_cast_mesh* meshes,
                                                              uint32_t count, const char** reason) {
  ReliefRaised* r = &relief->raised;
  if (count > relief->desc.mesh_capacity)
    return refuse(reason, SANDGLASS_ERROR_CAPACITY,
                  "there are more meshes than desc.mesh_capacity: create a larger relief.");
  for (uint32_t i = 0; i < count; ++i)
    if (const char* fault = mesh_fault(meshes[i])) return refuse(reason, fault);
  r->due = r->due || count != r->count;
  for (uint32_t i = 0; i < count; ++i) {
    ReliefMesh* mesh = &r->meshes[i];
    const bool known = i < r->count && same_arrays(mesh->asked, meshes[i]) && mesh->asked.version == meshes[i].version;
    mesh->asked = meshes[i];
    if (!known) find_rows(*relief, mesh->asked.world_from_mesh, mesh->rows);  // a raise may be under way
    r->due = r->due || !known || has_moved(*relief, *mesh);
  }
  r->count = count;
  return accept(reason);
}

}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_relief_set_meshes(sandglass_relief* relief, const sandglass_cast_mesh* meshes,
                                             uint32_t count, const char** reason) {
  if (relief == nullptr || (meshes == nullptr && count != 0))
    return refuse(reason, "relief or meshes is NULL: pass both.");
  const ExactFloatingPoint exact;
  return take_meshes(&relief->relief, meshes, count, reason);
}
