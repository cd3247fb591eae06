// Inside tests against shapes whose inside is a formula, at points that are chosen to be difficult, and on meshes with
// holes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "models/mesh/generated.h"
#include "models/tracing/embree_scene.h"
#include "runtime/math/random.h"
#include "runtime/solid/sampling/inside.h"
#include "tests/guarded_block.h"
#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

constexpr double k_major = 0.1, k_minor = 0.04;
constexpr uint32_t k_along = 96, k_around = 48;

host::Mesh test_torus() { return host::make_torus(0.1f, 0.04f, k_along, k_around); }

// Signed distance to the analytic torus, negative inside.
double torus_distance(const float p[3]) {
  const double ring = std::hypot(static_cast<double>(p[0]), static_cast<double>(p[2])) - k_major;
  return std::hypot(ring, static_cast<double>(p[1])) - k_minor;
}

// Vertices lie on the torus, so a facet is off it by at most the sagitta of its edges: r(1 - cos(pi/n)) of the two
// circles together, the outer one being the larger, and of the diagonal no more than their sum.
const double k_sag =
    (k_major + k_minor) * (1 - std::cos(3.14159265 / k_along)) + k_minor * (1 - std::cos(3.14159265 / k_around));

Points random_points(int count, uint64_t seed, double reach_xz, double reach_y) {
  Random random = random_stream(seed, 0);
  Points points;
  for (int i = 0; i < count; ++i)
    for (double reach : {reach_xz, reach_y, reach_xz})
      points.push_back(static_cast<float>((2 * random.uniform() - 1) * reach));
  return points;
}

TEST(Inside, both_rules_agree_with_the_analytic_torus_also_inside_out) {
  const Points points = random_points(40000, 3, 0.16, 0.06);
  host::Mesh torus = test_torus();
  for (const bool inside_out : {false, true}) {
    if (inside_out)
      for (size_t t = 0; t < torus.indices.size(); t += 3) std::swap(torus.indices[t], torus.indices[t + 1]);
    const sandglass::MeshInside parity = inside_of(torus, SANDGLASS_INSIDE_PARITY),
                                winding = inside_of(torus, SANDGLASS_INSIDE_WINDING);
    int in_band = 0, in_torus = 0;
    for (size_t i = 0; i < points.size(); i += 3) {
      const float* p = &points[i];
      const double distance = torus_distance(p);
      in_torus += distance < 0;
      if (std::fabs(distance) <= 1.01 * k_sag) {
        ++in_band;
        continue;
      }
      ASSERT_EQ(parity(p), distance < 0) << p[0] << " " << p[1] << " " << p[2];
      ASSERT_EQ(winding(p), distance < 0) << p[0] << " " << p[1] << " " << p[2];
    }
    EXPECT_GT(in_torus, 5000);
    EXPECT_LT(in_band, 400);  // the band is thin, so nearly all points are tested
    const float far[3] = {1e30f, 0, 0}, nan[3] = {std::nanf(""), 0, 0}, infinite[3] = {0, INFINITY, 0};
    for (const float* p : {far, nan, infinite}) EXPECT_FALSE(parity(p) || winding(p));
  }
}

TEST(Inside, parity_is_right_where_rays_meet_vertices_and_edges) {
  // Points that share one, two coordinates with vertices, or lie in the planes of axis-aligned faces. The ray passes
  // through vertices, along edges, within faces.
  const host::Mesh torus = test_torus();
  const sandglass::MeshInside inside = inside_of(torus, SANDGLASS_INSIDE_PARITY);
  Random random = random_stream(11, 0);
  int tested = 0;
  for (int n = 0; n < 60000; ++n) {
    const float* vertex = &torus.vertices[3 * random.below(torus.vertex_count())];
    float p[3] = {vertex[0], vertex[1], vertex[2]};
    const uint32_t axis = random.below(3);
    p[axis] = static_cast<float>((2 * random.uniform() - 1) * (axis == 1 ? 0.06 : 0.16));
    if (n % 3 == 0) p[(axis + 1) % 3] = torus.vertices[3 * random.below(torus.vertex_count()) + (axis + 1) % 3];
    const double distance = torus_distance(p);
    if (std::fabs(distance) <= 1.01 * k_sag) continue;
    ++tested;
    ASSERT_EQ(inside(p), distance < 0) << p[0] << " " << p[1] << " " << p[2];
  }
  EXPECT_GT(tested, 30000);
}

TEST(Inside, parity_is_right_in_the_planes_of_a_turned_notched_block) {
  // An L-shaped prism along each axis in turn: points on the extensions of its walls, which the ray runs within.
  const float outline[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  const uint32_t faces[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto turned = [axis](float along, float x, float y) {
      std::array<float, 3> p;
      p[axis] = along;
      p[(axis + 1) % 3] = x;
      p[(axis + 2) % 3] = y;
      return p;
    };
    host::Mesh block;
    for (float end : {0.0f, 3.0f})
      for (const auto& corner : outline) {
        const std::array<float, 3> p = turned(end, corner[0], corner[1]);
        block.vertices.insert(block.vertices.end(), p.begin(), p.end());
      }
    for (const auto& f : faces) {
      block.indices.insert(block.indices.end(), {f[0], f[2], f[1]});
      block.indices.insert(block.indices.end(), {6 + f[0], 6 + f[1], 6 + f[2]});
    }
    for (uint32_t i = 0; i < 6; ++i) {
      const uint32_t j = (i + 1) % 6;
      block.indices.insert(block.indices.end(), {i, j, 6 + j, i, 6 + j, 6 + i});
    }
    const sandglass::MeshInside parity = inside_of(block, SANDGLASS_INSIDE_PARITY),
                                winding = inside_of(block, SANDGLASS_INSIDE_WINDING);
    for (int u = 0; u < 40; ++u)
      for (int v = 0; v < 40; ++v)
        for (int w = 0; w < 12; ++w) {
          // Multiples of 1/16 from 1/32 on, and the planes at 1 themselves: there a point is off the surface only where
          // the L is.
          const float x = u == 39 ? 1 : (static_cast<float>(u) + 0.5f) / 16;
          const float y = v == 39 ? 1 : (static_cast<float>(v) + 0.5f) / 16, z = (static_cast<float>(w) + 0.5f) / 4;
          if ((x == 1 && y >= 1) || (y == 1 && x >= 1)) continue;
          const std::array<float, 3> p = turned(z, x, y);
          const bool truth = z < 3 && x < 2 && y < 2 && !(x > 1 && y > 1);
          ASSERT_EQ(parity(p.data()), truth) << axis << ": " << x << " " << y << " " << z;
          ASSERT_EQ(winding(p.data()), truth) << axis << ": " << x << " " << y << " " << z;
        }
  }
}

// The largest error of the tree's number at random points, against the sum over all triangles.
double worst_tree_error(const host::Mesh& mesh, int count, double reach) {
  const sandglass_mesh surface = mesh.view();
  const sandglass::Box box = bounds_of(mesh);
  Winding tree = measure_winding(surface);
  Layout size;
  lay_out_winding(&size, &tree);
  GuardedBlock block(size.size);
  Layout layout;
  layout.base = static_cast<uint8_t*>(block.data());
  lay_out_winding(&layout, &tree);
  build_winding(surface, box.min, box.max, &tree);
  EXPECT_TRUE(block.guards_intact());
  const Points points = random_points(count, 5, reach, reach);
  double worst = 0;
  for (size_t i = 0; i < points.size(); i += 3) {
    double exact = 0;
    EXPECT_EQ(sandglass_mesh_winding_number(&surface, &points[i], &exact, nullptr), SANDGLASS_OK);
    worst = std::max(worst, std::fabs(winding_number(tree, &points[i]) - exact));
  }
  return worst;
}

TEST(Inside, tree_stays_within_its_error) {  // 0.04, as the header says
  EXPECT_LT(worst_tree_error(host::make_trefoil(0.1f, 0.018f, 200, 16), 300, 0.13), 0.04);
  EXPECT_LT(worst_tree_error(host::make_icosphere(1, 4), 300, 1.3), 0.04);
  const float plate[3] = {1, 0.01f, 1};
  EXPECT_LT(worst_tree_error(host::make_box(plate), 300, 0.8), 0.04);
}

template <class Keep>
void keep_triangles(host::Mesh* mesh, const Keep& keep) {
  std::vector<uint32_t> kept;
  for (size_t t = 0; t < mesh->indices.size(); t += 3) {
    const uint32_t* i = &mesh->indices[t];
    const std::vector<float>& v = mesh->vertices;
    if (keep(&v[3 * i[0]], &v[3 * i[1]], &v[3 * i[2]])) kept.insert(kept.end(), i, i + 3);
  }
  mesh->indices = kept;
}

TEST(Inside, winding_number_is_a_fraction_where_the_mesh_is_open) {
  // Seen from the centre, the lower half of a sphere fills half of all directions. This tests (3.27) of the
  // dissertation, corrected.
  host::Mesh half = host::make_icosphere(1, 3);
  const double all = static_cast<double>(half.indices.size());
  keep_triangles(&half, [](const float* a, const float* b, const float* c) { return a[1] + b[1] + c[1] < 0; });
  const double share = static_cast<double>(half.indices.size()) / all;
  const sandglass_mesh mesh = half.view();
  const float centre[3] = {0, 0, 0};
  double winding = 0;
  const char* reason = nullptr;
  ASSERT_EQ(sandglass_mesh_winding_number(&mesh, centre, &winding, &reason), SANDGLASS_OK);
  EXPECT_NEAR(winding, share, 0.03);  // triangles of an icosphere differ a little in solid angle
}

TEST(Inside, winding_decides_for_a_mesh_with_a_hole_where_parity_cannot) {
  host::Mesh sphere = host::make_icosphere(1, 3);
  const size_t all = sphere.indices.size();
  // A hole around the +x axis of some 5 % of the surface.
  keep_triangles(&sphere, [](const float* a, const float*, const float*) { return a[0] < 0.9f; });
  ASSERT_LT(sphere.indices.size(), all);
  const sandglass::MeshInside winding = inside_of(sphere, SANDGLASS_INSIDE_WINDING);
  const Points points = random_points(20000, 4, 1.3, 1.3);
  for (size_t i = 0; i < points.size(); i += 3) {
    const float* p = &points[i];
    const double r = std::sqrt(static_cast<double>(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
    if (p[0] > 0.55f || std::fabs(r - 1) < 0.02) continue;  // near the hole it is not defined what is inside
    ASSERT_EQ(winding(p), r < 1) << p[0] << " " << p[1] << " " << p[2];
  }
}

TEST(Inside, prepared_block_does_not_need_the_mesh_any_more) {
  auto mesh = std::make_unique<host::Mesh>(test_torus());
  const sandglass::MeshInside parity = inside_of(*mesh, SANDGLASS_INSIDE_PARITY),
                              winding = inside_of(*mesh, SANDGLASS_INSIDE_WINDING);
  std::fill(mesh->vertices.begin(), mesh->vertices.end(), 0.0f);
  mesh.reset();
  const float in[3] = {0.1f, 0, 0}, out[3] = {0, 0, 0};
  EXPECT_TRUE(parity(in) && winding(in));
  EXPECT_FALSE(parity(out) || winding(out));
}

#ifdef SANDGLASS_HAVE_EMBREE
TEST(EmbreeScene, finds_the_faces_of_a_box) {
  const float size[3] = {2, 2, 2};
  const host::Vec3 origin = {0.1, 5, 0.2}, down = {0, -1, 0}, up = {0, 1, 0};
  const host::Mesh box = host::make_box(size);
  const host::EmbreeScene scene = host::EmbreeScene::triangles(box.vertices, box.indices);
  const host::EmbreeHit hit = scene.closest(origin, down, 100);
  ASSERT_TRUE(hit.found);
  EXPECT_NEAR(hit.distance, 4, 1e-5);
  EXPECT_NEAR(hit.unit_normal().y, 1, 1e-6);
  EXPECT_TRUE(scene.occluded(origin, down, 100));
  EXPECT_FALSE(scene.occluded(origin, down, 3.9));
  EXPECT_FALSE(scene.occluded(origin, up, 100));
  EXPECT_FALSE(scene.closest(origin, up, 100).found);
}
#endif

}  // namespace
}  // namespace sandglass::test
