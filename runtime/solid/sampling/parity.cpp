// Inside by parity of ray crossings, in exact arithmetic.
//
// A ray along an axis hits a triangle if the point's projection lies in that of the triangle. That is decided edge by
// edge. An edge counts if its ends lie on different sides of the point in v, one of them inclusive, and the point lies
// strictly on its lower-u side. The outcome depends on the edge and the point alone, so the two triangles at an edge
// agree. A whole line through a closed mesh then hits an even number of triangles, whatever it passes through: vertices
// and edges need no case of their own. Rounded signs would spoil this. With coordinates rounded to 26 bits the products
// fit 64-bit integers.
#include "runtime/math/math.h"
#include "runtime/solid/sampling/inside.h"

namespace sandglass {
namespace {

constexpr int32_t k_steps = (1 << 26) - 1;

int64_t snap(const Parity& p, int axis, float x) {
  return floor_index((static_cast<double>(x) - p.origin[axis]) * p.steps_per_metre + 0.5);
}

void snap_triangle(const Parity& p, const sandglass_mesh& mesh, uint32_t triangle, int32_t out[9]) {
  for (int corner = 0; corner < 3; ++corner) {
    const float* vertex = mesh.vertices + 3ull * mesh.indices[3ull * triangle + corner];
    out[3 * corner + 0] = static_cast<int32_t>(snap(p, p.u_axis, vertex[p.u_axis]));
    out[3 * corner + 1] = static_cast<int32_t>(snap(p, p.v_axis, vertex[p.v_axis]));
    out[3 * corner + 2] = static_cast<int32_t>(snap(p, p.ray_axis, vertex[p.ray_axis]));
  }
}

int32_t minimum(int32_t a, int32_t b, int32_t c) { return a < b ? (a < c ? a : c) : (b < c ? b : c); }
int32_t maximum(int32_t a, int32_t b, int32_t c) { return a > b ? (a > c ? a : c) : (b > c ? b : c); }

struct ColumnRange {
  uint32_t u_first, u_last, v_first, v_last;
};

ColumnRange columns_of(const int32_t t[9], uint32_t shift) {
  return {static_cast<uint32_t>(minimum(t[0], t[3], t[6])) >> shift,
          static_cast<uint32_t>(maximum(t[0], t[3], t[6])) >> shift,
          static_cast<uint32_t>(minimum(t[1], t[4], t[7])) >> shift,
          static_cast<uint32_t>(maximum(t[1], t[4], t[7])) >> shift};
}

void set_columns(Parity* p, uint32_t shift) {
  const float extent_u = p->bounds_max[p->u_axis], extent_v = p->bounds_max[p->v_axis];
  p->shift = shift;
  p->columns_u = (static_cast<uint32_t>(snap(*p, p->u_axis, extent_u)) >> shift) + 1;
  p->columns_v = (static_cast<uint32_t>(snap(*p, p->v_axis, extent_v)) >> shift) + 1;
}

uint64_t count_references(const Parity& p, const sandglass_mesh& mesh) {
  uint64_t references = 0;
  for (uint32_t i = 0; i < mesh.triangle_count; ++i) {
    int32_t t[9];
    snap_triangle(p, mesh, i, t);
    const ColumnRange r = columns_of(t, p.shift);
    references += static_cast<uint64_t>(r.u_last - r.u_first + 1) * (r.v_last - r.v_first + 1);
  }
  return references;
}

bool covers(const int32_t t[9], int64_t u, int64_t v) {
  bool odd = false;
  for (int k = 0; k < 3; ++k) {
    const int32_t *a = t + 3 * k, *b = t + 3 * ((k + 1) % 3);
    if ((a[1] > v) == (b[1] > v)) continue;
    const int64_t side =
        (static_cast<int64_t>(b[0]) - a[0]) * (v - a[1]) - (static_cast<int64_t>(b[1]) - a[1]) * (u - a[0]);
    if (b[1] > a[1] ? side > 0 : side < 0) odd = !odd;
  }
  return odd;
}

// Whether a triangle that covers (u, v) passes strictly above w: the sign of det[b-a, c-a, p-a] against that of the
// projected area. The minors have 55 bits and the factors 28. So each minor is split, and the three products are added
// in two parts.
bool passes_above(const int32_t t[9], int64_t u, int64_t v, int64_t w) {
  if (w >= maximum(t[2], t[5], t[8])) return false;
  if (w < minimum(t[2], t[5], t[8])) return true;
  int64_t e[3], f[3];
  const int64_t d[3] = {u - t[0], v - t[1], w - t[2]};
  for (int k = 0; k < 3; ++k) {
    e[k] = static_cast<int64_t>(t[3 + k]) - t[k];
    f[k] = static_cast<int64_t>(t[6 + k]) - t[k];
  }
  const int64_t normal[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
  int64_t high = 0, low = 0;
  for (int k = 0; k < 3; ++k) {
    high += (normal[k] >> 28) * d[k];
    low += (normal[k] & ((1 << 28) - 1)) * d[k];
  }
  high += low >> 28;
  const int sign = high != 0 ? (high < 0 ? -1 : 1) : (low & ((1 << 28) - 1)) != 0 ? 1 : 0;
  return normal[2] > 0 ? sign < 0 : sign > 0;
}

}  // namespace

// The finest grid with at most 4 columns for each triangle, whose lists have at most 16 entries for each triangle.
// Small meshes may have 64 more of each.
Parity measure_parity(const sandglass_mesh& mesh, const float bounds_min[3], const float bounds_max[3]) {
  Parity p = {};
  double extent[3];
  for (int k = 0; k < 3; ++k) {
    p.bounds_min[k] = bounds_min[k];
    p.bounds_max[k] = bounds_max[k];
    p.origin[k] = static_cast<double>(bounds_min[k]);
    extent[k] = static_cast<double>(bounds_max[k]) - p.origin[k];
    if (extent[k] > extent[p.ray_axis]) p.ray_axis = k;
  }
  p.u_axis = (p.ray_axis + 1) % 3;
  p.v_axis = (p.ray_axis + 2) % 3;
  p.steps_per_metre = extent[p.ray_axis] > 0 ? k_steps / extent[p.ray_axis] : 0;
  const uint64_t columns_wanted = 64 + 4ull * mesh.triangle_count, references_wanted = 64 + 16ull * mesh.triangle_count;
  uint32_t shift = 26;
  for (set_columns(&p, shift); shift > 0; --shift) {
    set_columns(&p, shift - 1);
    if (static_cast<uint64_t>(p.columns_u) * p.columns_v > columns_wanted) break;
  }
  set_columns(&p, shift);
  uint64_t references = count_references(p, mesh);
  for (; references > references_wanted; references = count_references(p, mesh)) set_columns(&p, p.shift + 1);
  p.references = static_cast<uint32_t>(references);
  return p;
}

void lay_out_parity(Layout* layout, const sandglass_mesh& mesh, Parity* p) {
  p->triangles = layout_region<int32_t>(layout, "sampling.parity.triangles", 9ull * mesh.triangle_count);
  p->column_first =
      layout_region<uint32_t>(layout, "sampling.parity.first", static_cast<uint64_t>(p->columns_u) * p->columns_v + 1);
  p->column_list = layout_region<uint32_t>(layout, "sampling.parity.list", p->references);
}

void build_parity(const sandglass_mesh& mesh, Parity* p) {
  const uint32_t columns = p->columns_u * p->columns_v;
  for (uint32_t i = 0; i <= columns; ++i) p->column_first[i] = 0;
  for (uint32_t i = 0; i < mesh.triangle_count; ++i) {
    int32_t* t = p->triangles + 9ull * i;
    snap_triangle(*p, mesh, i, t);
    const ColumnRange r = columns_of(t, p->shift);
    for (uint32_t v = r.v_first; v <= r.v_last; ++v)
      for (uint32_t u = r.u_first; u <= r.u_last; ++u) ++p->column_first[v * p->columns_u + u + 1];
  }
  for (uint32_t i = 0; i < columns; ++i) p->column_first[i + 1] += p->column_first[i];
  for (uint32_t i = 0; i < mesh.triangle_count; ++i) {
    const ColumnRange r = columns_of(p->triangles + 9ull * i, p->shift);
    for (uint32_t v = r.v_first; v <= r.v_last; ++v)
      for (uint32_t u = r.u_first; u <= r.u_last; ++u) p->column_list[p->column_first[v * p->columns_u + u]++] = i;
  }
  for (uint32_t i = columns; i > 0; --i) p->column_first[i] = p->column_first[i - 1];
  p->column_first[0] = 0;
}

bool parity_inside(const Parity& p, const float point[3]) {
  for (int k = 0; k < 3; ++k)
    if (!(point[k] >= p.bounds_min[k] && point[k] <= p.bounds_max[k])) return false;
  const int64_t u = snap(p, p.u_axis, point[p.u_axis]), v = snap(p, p.v_axis, point[p.v_axis]);
  const int64_t w = snap(p, p.ray_axis, point[p.ray_axis]);
  const uint32_t column = static_cast<uint32_t>(v >> p.shift) * p.columns_u + static_cast<uint32_t>(u >> p.shift);
  bool odd = false;
  for (uint32_t i = p.column_first[column]; i < p.column_first[column + 1]; ++i) {
    const int32_t* t = p.triangles + 9ull * p.column_list[i];
    if (covers(t, u, v) && passes_above(t, u, v, w)) odd = !odd;
  }
  return odd;
}

}  // namespace sandglass
