// Generalised winding number (3.27, 3.28), for one point exactly or for many through a tree.
//
// From afar a cluster of triangles looks like a dipole: the sum of area * normal at the centre of the cluster. The
// first moment about the centre corrects most of the rest (Barill et al. 2018, the first order of their expansion). A
// cluster counts as far beyond k_far times its radius. Nearer ones are opened, and in the end triangles are taken
// exactly.
#include "kernels/whole.h"
#include "runtime/math/math.h"
#include "runtime/solid/sampling/arguments.h"
#include "runtime/solid/sampling/inside.h"

namespace sandglass {
namespace {

constexpr uint32_t k_leaf_triangles = 8;
constexpr double k_far = 2.5;
constexpr uint32_t k_stack_size = 64;  // the tree has at most 25 levels, and each leaves one node waiting

uint64_t spread_bits(uint64_t x) {  // 10 bits, with two zeros between neighbours
  x = (x | x << 16) & 0x030000FF;
  x = (x | x << 8) & 0x0300F00F;
  x = (x | x << 4) & 0x030C30C3;
  return (x | x << 2) & 0x09249249;
}

void sift_down(uint64_t* keys, uint32_t place, uint32_t count) {
  const uint64_t key = keys[place];
  for (uint32_t child = 2 * place + 1; child < count; child = 2 * place + 1) {
    if (child + 1 < count && keys[child + 1] > keys[child]) ++child;
    if (keys[child] <= key) break;
    keys[place] = keys[child];
    place = child;
  }
  keys[place] = key;
}

void heap_sort(uint64_t* keys, uint32_t count) {
  for (uint32_t i = count / 2; i-- > 0;) sift_down(keys, i, count);
  for (uint32_t end = count; end > 1;) {
    const uint64_t top = keys[0];
    keys[0] = keys[--end];
    keys[end] = top;
    sift_down(keys, 0, end);
  }
}

void read_triangle(const sandglass_mesh& mesh, uint32_t triangle, float out[9]) {
  for (int i = 0; i < 9; ++i) out[i] = mesh.vertices[3ull * mesh.indices[3ull * triangle + i / 3] + i % 3];
}

struct Facet {
  double centroid[3], dipole[3], area;
};

Facet facet_of(const float t[9]) {
  Facet facet;
  double e[3], f[3];
  for (int k = 0; k < 3; ++k) {
    const double a = static_cast<double>(t[k]), b = static_cast<double>(t[3 + k]), c = static_cast<double>(t[6 + k]);
    e[k] = b - a;
    f[k] = c - a;
    facet.centroid[k] = (a + b + c) / 3;
  }
  facet.dipole[0] = 0.5 * (e[1] * f[2] - e[2] * f[1]);
  facet.dipole[1] = 0.5 * (e[2] * f[0] - e[0] * f[2]);
  facet.dipole[2] = 0.5 * (e[0] * f[1] - e[1] * f[0]);
  facet.area = square_root(facet.dipole[0] * facet.dipole[0] + facet.dipole[1] * facet.dipole[1] +
                           facet.dipole[2] * facet.dipole[2]);
  return facet;
}

void add_moment(WindingNode* node, const double dipole[3], const double place[3]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) node->moment[3 * i + j] += dipole[i] * (place[j] - node->centre[j]);
}

double separation(const double a[3], const double b[3]) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return square_root(sum);
}

// Centres are weighted by area. A trace is added, so that parts without area have a centre too.
constexpr double k_trace = 1e-300;

WindingNode make_leaf(const Winding& w, uint32_t leaf) {
  WindingNode node = {};
  const uint64_t first = static_cast<uint64_t>(leaf) * k_leaf_triangles;
  const uint64_t last = first + k_leaf_triangles < w.triangle_count ? first + k_leaf_triangles : w.triangle_count;
  node.radius = -1;
  double weight = 0;
  for (uint64_t i = first; i < last; ++i) {
    const Facet facet = facet_of(w.triangles + 9 * i);
    weight += facet.area + k_trace;
    node.area += facet.area;
    for (int k = 0; k < 3; ++k) {
      node.centre[k] += (facet.area + k_trace) * facet.centroid[k];
      node.dipole[k] += facet.dipole[k];
    }
  }
  if (first >= last) return node;
  for (double& c : node.centre) c /= weight;
  for (uint64_t i = first; i < last; ++i) {
    const float* t = w.triangles + 9 * i;
    const Facet facet = facet_of(t);
    add_moment(&node, facet.dipole, facet.centroid);
    for (int corner = 0; corner < 3; ++corner) {
      const double place[3] = {static_cast<double>(t[3 * corner]), static_cast<double>(t[3 * corner + 1]),
                               static_cast<double>(t[3 * corner + 2])};
      const double reach = separation(place, node.centre);
      if (reach > node.radius) node.radius = reach;
    }
  }
  return node;
}

WindingNode join(const WindingNode& a, const WindingNode& b) {
  if (b.radius < 0) return a;  // leaves fill from the left, so only the right side may be empty
  WindingNode node = {};
  node.area = a.area + b.area;
  const double share_a = (a.area + k_trace) / (node.area + 2 * k_trace);
  for (int k = 0; k < 3; ++k) {
    node.centre[k] = share_a * a.centre[k] + (1 - share_a) * b.centre[k];
    node.dipole[k] = a.dipole[k] + b.dipole[k];
  }
  for (int i = 0; i < 9; ++i) node.moment[i] = a.moment[i] + b.moment[i];
  add_moment(&node, a.dipole, a.centre);
  add_moment(&node, b.dipole, b.centre);
  const double reach_a = separation(node.centre, a.centre) + a.radius,
               reach_b = separation(node.centre, b.centre) + b.radius;
  node.radius = reach_a > reach_b ? reach_a : reach_b;
  return node;
}

// The sum over the cluster of dipole . d/|d|^3, to first order in the distance from the centre. d runs from the point
// to the centre.
double far_solid_angle(const WindingNode& node, const double d[3], double squared) {
  double along = 0, trace = 0, bilinear = 0;
  for (int i = 0; i < 3; ++i) {
    along += node.dipole[i] * d[i];
    trace += node.moment[4 * i];
    for (int j = 0; j < 3; ++j) bilinear += d[i] * node.moment[3 * i + j] * d[j];
  }
  return (along + trace - 3 * bilinear / squared) / (squared * square_root(squared));
}

}  // namespace

double solid_angle(const float t[9], const double point[3]) {
  double e[3][3], norm[3];
  for (int corner = 0; corner < 3; ++corner) {
    for (int k = 0; k < 3; ++k) e[corner][k] = static_cast<double>(t[3 * corner + k]) - point[k];
    norm[corner] = square_root(e[corner][0] * e[corner][0] + e[corner][1] * e[corner][1] + e[corner][2] * e[corner][2]);
  }
  const double determinant = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                             e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
  double ab = 0, bc = 0, ca = 0;
  for (int k = 0; k < 3; ++k) {
    ab += e[0][k] * e[1][k];
    bc += e[1][k] * e[2][k];
    ca += e[2][k] * e[0][k];
  }
  return 2 * arc_tangent2(determinant, norm[0] * norm[1] * norm[2] + ab * norm[2] + bc * norm[0] + ca * norm[1]);
}

Winding measure_winding(const sandglass_mesh& mesh) {
  Winding w = {};
  w.triangle_count = mesh.triangle_count;
  w.leaf_count = 1;
  while (static_cast<uint64_t>(w.leaf_count) * k_leaf_triangles < mesh.triangle_count) w.leaf_count *= 2;
  return w;
}

void lay_out_winding(Layout* layout, Winding* w) {
  w->triangles = layout_region<float>(layout, "sampling.winding.triangles", 9ull * w->triangle_count);
  w->order = layout_region<uint64_t>(layout, "sampling.winding.order", w->triangle_count);
  w->nodes = layout_region<WindingNode>(layout, "sampling.winding.nodes", 2ull * w->leaf_count);
}

void build_winding(const sandglass_mesh& mesh, const float bounds_min[3], const float bounds_max[3], Winding* w) {
  double scale = 0;
  for (int k = 0; k < 3; ++k) {
    const double extent = static_cast<double>(bounds_max[k]) - static_cast<double>(bounds_min[k]);
    if (extent > scale) scale = extent;
  }
  scale = scale > 0 ? 1023 / scale : 0;
  for (uint32_t i = 0; i < w->triangle_count; ++i) {
    float t[9];
    read_triangle(mesh, i, t);
    const Facet facet = facet_of(t);
    uint64_t code = 0;
    for (int k = 0; k < 3; ++k)
      code |= spread_bits(to_whole<uint64_t>((facet.centroid[k] - static_cast<double>(bounds_min[k])) * scale) & 1023)
              << k;
    w->order[i] = code << 32 | i;
  }
  heap_sort(w->order, w->triangle_count);
  for (uint32_t i = 0; i < w->triangle_count; ++i)
    read_triangle(mesh, static_cast<uint32_t>(w->order[i]), w->triangles + 9ull * i);
  for (uint32_t leaf = 0; leaf < w->leaf_count; ++leaf) w->nodes[w->leaf_count + leaf] = make_leaf(*w, leaf);
  for (uint32_t n = w->leaf_count - 1; n > 0; --n) w->nodes[n] = join(w->nodes[2 * n], w->nodes[2 * n + 1]);
}

double winding_number(const Winding& w, const float position[3]) {
  const double point[3] = {static_cast<double>(position[0]), static_cast<double>(position[1]),
                           static_cast<double>(position[2])};
  uint32_t stack[k_stack_size];
  uint32_t waiting = 0;
  double sum = 0;
  stack[waiting++] = 1;
  while (waiting > 0) {
    const uint32_t n = stack[--waiting];
    const WindingNode& node = w.nodes[n];
    if (node.radius < 0) continue;
    const double d[3] = {node.centre[0] - point[0], node.centre[1] - point[1], node.centre[2] - point[2]};
    const double squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    if (squared > k_far * k_far * node.radius * node.radius) {
      sum += far_solid_angle(node, d, squared);
    } else if (n >= w.leaf_count) {
      const uint64_t first = static_cast<uint64_t>(n - w.leaf_count) * k_leaf_triangles;
      for (uint64_t i = first; i < first + k_leaf_triangles && i < w.triangle_count; ++i)
        sum += solid_angle(w.triangles + 9 * i, point);
    } else {
      stack[waiting++] = 2 * n;
      stack[waiting++] = 2 * n + 1;
    }
  }
  return sum / (4 * k_pi);
}

}  // namespace sandglass

extern "C" sandglass_status sandglass_mesh_winding_number(const sandglass_mesh* mesh, const float position[3],
                                                          double* winding, const char** reason) {
  using namespace sandglass;
  if (const sandglass_status status = check_mesh(mesh, reason)) return status;
  if (position == nullptr || winding == nullptr)
    return refuse(reason, "point or winding is NULL: pass 3 floats and room for a double.");
  double point[3], sum = 0;
  for (int k = 0; k < 3; ++k) {
    point[k] = static_cast<double>(position[k]);
    if (!is_finite(point[k])) return refuse(reason, "the point is not finite: check where it comes from.");
  }
  for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
    float t[9];
    read_triangle(*mesh, i, t);
    sum += solid_angle(t, point);
  }
  *winding = sum / (4 * k_pi);
  return accept(reason);
}
