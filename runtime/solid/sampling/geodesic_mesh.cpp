// See geodesic_mesh.h.
#include "runtime/solid/sampling/geodesic_mesh.h"

#include "runtime/math/math.h"
#include "runtime/math/random.h"

namespace sandglass {
namespace {

constexpr uint32_t k_none = 0xFFFFFFFFu;

bool same_edge(const GeodesicMesh& g, uint32_t h, uint32_t a, uint32_t b) {
  const uint32_t s = start_of(g, h), e = end_of(g, h);
  return (s == a && e == b) || (s == b && e == a);
}

void link_mates(const GeodesicMesh& g) {
  const uint32_t mask = (1u << g.table_bits) - 1;
  for (uint32_t i = 0; i <= mask; ++i) g.table[i] = k_none;
  for (uint32_t h = 0; h < 3 * g.mesh->triangle_count; ++h) {
    g.mate[h] = h;
    const uint32_t a = start_of(g, h), b = end_of(g, h);
    if (a == b) continue;
    const uint64_t key = a < b ? static_cast<uint64_t>(a) << 32 | b : static_cast<uint64_t>(b) << 32 | a;
    uint32_t slot = static_cast<uint32_t>(mix_bits(key)) & mask;
    while (g.table[slot] != k_none && !same_edge(g, g.table[slot], a, b)) slot = (slot + 1) & mask;
    if (g.table[slot] == k_none) {
      g.table[slot] = h;
    } else {
      g.mate[h] = g.mate[g.table[slot]];
      g.mate[g.table[slot]] = h;
    }
  }
}

void list_corners(const GeodesicMesh& g) {
  const uint32_t half_edges = 3 * g.mesh->triangle_count;
  for (uint32_t v = 0; v <= g.mesh->vertex_count; ++v) g.corner_first[v] = 0;
  for (uint32_t h = 0; h < half_edges; ++h) ++g.corner_first[start_of(g, h) + 1];
  for (uint32_t v = 0; v < g.mesh->vertex_count; ++v) g.corner_first[v + 1] += g.corner_first[v];
  // Filling moved each start to its end, which is the start of the next vertex: shift them back.
  for (uint32_t h = 0; h < half_edges; ++h) g.corners[g.corner_first[start_of(g, h)]++] = h;
  for (uint32_t v = g.mesh->vertex_count; v > 0; --v) g.corner_first[v] = g.corner_first[v - 1];
  g.corner_first[0] = 0;
}

double corner_angle(const GeodesicMesh& g, uint32_t h) {
  const float* a = vertex_position(g, start_of(g, h));
  const float* b = vertex_position(g, end_of(g, h));
  const float* c = vertex_position(g, start_of(g, previous_half_edge(h)));
  double e[3], f[3], dot = 0;
  for (int k = 0; k < 3; ++k) {
    e[k] = static_cast<double>(b[k]) - static_cast<double>(a[k]);
    f[k] = static_cast<double>(c[k]) - static_cast<double>(a[k]);
    dot += e[k] * f[k];
  }
  const double x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2], z = e[0] * f[1] - e[1] * f[0];
  return arc_tangent2(square_root(x * x + y * y + z * z), dot);
}

bool two_sided(const GeodesicMesh& g, uint32_t h) { return g.mate[h] != h && g.mate[g.mate[h]] == h; }

// Shortest paths turn only at vertices with more than a full angle around them, at boundaries, and where sheets meet.
void mark_bends(const GeodesicMesh& g) {
  for (uint32_t v = 0; v < g.mesh->vertex_count; ++v) {
    double angle = 0;
    bool plain = true;
    for (uint32_t i = g.corner_first[v]; i < g.corner_first[v + 1]; ++i) {
      const uint32_t h = g.corners[i];
      angle += corner_angle(g, h);
      plain = plain && two_sided(g, h) && two_sided(g, previous_half_edge(h));
    }
    g.bends[v] = !plain || angle > 2 * k_pi + 1e-9;
  }
}

}  // namespace

GeodesicMesh lay_out_geodesic_mesh(Layout* layout, const sandglass_mesh* mesh) {
  const uint64_t half_edges = 3ull * mesh->triangle_count;
  GeodesicMesh g = {};
  g.mesh = mesh;
  g.table_bits = 1;
  while ((1ull << g.table_bits) < half_edges + half_edges / 3) ++g.table_bits;
  g.mate = layout_region<uint32_t>(layout, "sampling.geodesic.mate", half_edges);
  g.corner_first = layout_region<uint32_t>(layout, "sampling.geodesic.corner_first", mesh->vertex_count + 1ull);
  g.corners = layout_region<uint32_t>(layout, "sampling.geodesic.corners", half_edges);
  g.bends = layout_region<uint8_t>(layout, "sampling.geodesic.bends", mesh->vertex_count);
  g.table = layout_region<uint32_t>(layout, "sampling.geodesic.table", 1ull << g.table_bits);
  return g;
}

void build_geodesic_mesh(const GeodesicMesh& g) {
  link_mates(g);
  list_corners(g);
  mark_bends(g);
}

}  // namespace sandglass
