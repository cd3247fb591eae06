// Generated meshes against their formulas; cleaning and the counts of edges; files are written whole or not at all.
#include "models/mesh/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/mesh/ply.h"
#include "tests/solid/point_checks.h"
#include "tests/temporary_folder.h"

namespace sandglass::test {
namespace {

constexpr double k_pi = 3.14159265358979323846;

std::string content(const std::string& path) { return host::read_file(path, "file"); }

size_t files_in(const tests::TemporaryFolder& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder.path), {}));
}

int euler_characteristic(const host::Mesh& mesh) {
  return static_cast<int>(mesh.vertex_count()) - static_cast<int>(3 * mesh.triangle_count() / 2) +
         static_cast<int>(mesh.triangle_count());
}

TEST(Generated, are_closed_and_oriented_outwards) {
  const float size[3] = {1, 2, 3};
  for (const host::Mesh& mesh :
       {host::make_trefoil(), host::make_torus(1, 0.4f, 30, 20), host::make_box(size), host::make_icosphere(1, 2),
        host::make_named("hourglass").mesh, host::make_named("bucket").mesh, host::make_named("silo").mesh}) {
    const host::MeshResult checked = host::clean_mesh(mesh.vertices, mesh.indices, "generated");
    ASSERT_TRUE(checked) << checked.error;
    EXPECT_TRUE(checked.report.manifold() && checked.report.watertight());
    EXPECT_EQ(host::describe_faults(checked.report), "");
    EXPECT_EQ(checked.report.merged_vertices, 0u);
    EXPECT_EQ(checked.mesh.indices, mesh.indices);
    EXPECT_GT(host::signed_volume(mesh), 0);
  }
  EXPECT_EQ(euler_characteristic(host::make_trefoil()), 0);
  EXPECT_EQ(euler_characteristic(host::make_icosphere(1, 3)), 2);
  EXPECT_EQ(euler_characteristic(host::make_named("hourglass").mesh), 2);
  EXPECT_EQ(euler_characteristic(host::make_named("bucket").mesh), 2) << "a bucket is a ball, dented";
  EXPECT_EQ(euler_characteristic(host::make_named("silo").mesh), 0) << "a funnel is a ring";
}

// A point of the trefoil's axis.
std::array<double, 3> knot(double t) {
  return {(std::sin(t) + 2 * std::sin(2 * t)) / 30, (std::cos(t) - 2 * std::cos(2 * t)) / 30, -std::sin(3 * t) / 30};
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

TEST(Generated, have_the_volumes_of_their_shapes) {
  const float size[3] = {1, 2, 3};
  EXPECT_NEAR(host::signed_volume(host::make_box(size)), 6, 1e-6);
  // An inscribed polygon of n sides has the share sin(2 pi/n)/(2 pi/n) of the circle, to first order 1 - (2 pi/n)^2/6.
  const double torus = 2 * k_pi * k_pi * 0.4 * 0.4;
  EXPECT_NEAR(host::signed_volume(host::make_torus(1, 0.4f, 200, 100)) / torus, 1, std::pow(2 * k_pi / 100, 2) / 3);
  EXPECT_NEAR(host::signed_volume(host::make_icosphere(1, 5)) / (4 * k_pi / 3), 1, 0.002);
  // Pappus: the tube's cross-section times the knot's length, here summed in double.
  double length = 0;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) length += distance(knot(2 * k_pi * i / steps), knot(2 * k_pi * (i + 1) / steps));
  EXPECT_NEAR(host::signed_volume(host::make_trefoil()) / (length * k_pi * 0.018 * 0.018), 1,
              std::pow(2 * k_pi / 32, 2) / 3);
}

double frustum(double height, double r, double s) { return k_pi * height * (r * r + r * s + s * s) / 3; }

TEST(Generated, revolved_ones_have_the_volumes_of_their_frusta) {
  // Every cross-section is a regular polygon with sin(a)/a of its circle's area, a = 2 pi/sides.
  constexpr uint32_t k_sides = 60;
  const double angle = 2 * k_pi / k_sides, share = std::sin(angle) / angle;
  const double slope = (0.10 - 0.07) / 0.20, rim = 0.07 + slope * 0.18;
  const double bucket = frustum(0.18, 0.07, rim) + k_pi * 0.02 * 0.11 * 0.11 - frustum(0.19, 0.06, 0.09);
  EXPECT_NEAR(host::signed_volume(host::make_revolved(host::bucket_profile(0.2, 0.07, 0.1, 0.01), k_sides)) / bucket,
              share, 1e-5);
  const double silo =
      frustum(0.1, 0.03, 0.09) + k_pi * 0.2 * 0.09 * 0.09 - frustum(0.1, 0.02, 0.08) - k_pi * 0.2 * 0.08 * 0.08;
  EXPECT_NEAR(host::signed_volume(host::make_revolved(host::silo_profile(0.3, 0.08, 0.1, 0.02, 0.01), k_sides)) / silo,
              share, 1e-5);
}

TEST(Generated, hourglass_outline_lies_on_its_radius_and_mirrors) {
  const host::Profile profile = host::hourglass_profile(0.3, 0.08, 0.02, 20);
  double lowest = 1;
  for (size_t i = 1; i + 1 < profile.size(); ++i) {
    const auto [r, y] = profile[i];
    EXPECT_NEAR(host::hourglass_radius(0.3, 0.08, 0.02, y), r, 1e-6);
    EXPECT_NEAR(profile[profile.size() - 1 - i][1], 0.3 - y, 1e-12);
    lowest = std::min(lowest, r);
  }
  EXPECT_EQ(lowest, 0.02);
  EXPECT_EQ(host::hourglass_radius(0.3, 0.08, 0.02, 0.31), 0);
}

TEST(Generated, unknown_name_is_a_sentence) {
  const host::MeshResult result = host::make_named("klein-bottle");
  EXPECT_FALSE(result);
  EXPECT_NE(result.error.find("klein-bottle"), std::string::npos);
  EXPECT_TRUE(host::make_named("trefoil"));
}

TEST(Clean, merges_duplicates_and_drops_degenerates) {
  // A tetrahedron in which every face has its own three vertices, one of them at -0, and two degenerate triangles.
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::vector<float> vertices;
  std::vector<uint32_t> indices;
  for (const auto& face : faces)
    for (int corner : face) {
      indices.push_back(static_cast<uint32_t>(vertices.size() / 3));
      for (float x : corners[corner]) vertices.push_back(vertices.empty() ? -x : x);
    }
  indices.insert(indices.end(), {0, 0, 1, 0, 3, 1});  // vertex 3 is a copy of vertex 0
  const host::MeshResult result = host::clean_mesh(vertices, indices, "tetrahedron");
  ASSERT_TRUE(result) << result.error;
  EXPECT_EQ(result.mesh.vertex_count(), 4u);
  EXPECT_EQ(result.mesh.triangle_count(), 4u);
  EXPECT_EQ(result.report.merged_vertices, 8u);
  EXPECT_EQ(result.report.degenerate_triangles, 2u);
  EXPECT_TRUE(result.report.manifold());
  EXPECT_NEAR(host::signed_volume(result.mesh), 1.0 / 6, 1e-7);
}

TEST(Clean, counts_the_faults_of_edges) {
  host::Mesh box = host::make_box(std::array{1.0f, 1.0f, 1.0f}.data());
  const auto report = [](const host::Mesh& mesh) {
    return host::clean_mesh(mesh.vertices, mesh.indices, "box").report;
  };
  host::Mesh open = box;
  open.indices.resize(open.indices.size() - 3);
  EXPECT_EQ(report(open).boundary_edges, 3u);
  EXPECT_FALSE(report(open).watertight());
  host::Mesh flipped = box;
  std::swap(flipped.indices[0], flipped.indices[1]);
  EXPECT_EQ(report(flipped).inconsistent_edges, 3u);
  EXPECT_TRUE(report(flipped).watertight());  // parity works for any orientation
  EXPECT_FALSE(report(flipped).manifold());
  host::Mesh fin = box;  // a triangle that stands on one of the box's edges
  fin.vertices.insert(fin.vertices.end(), {2, 2, 2});
  fin.indices.insert(fin.indices.end(), {fin.indices[0], fin.indices[1], 8});
  EXPECT_EQ(report(fin).non_manifold_edges, 1u);
  EXPECT_EQ(report(fin).boundary_edges, 2u);
  EXPECT_EQ(report(fin).odd_edges, 3u);
  EXPECT_NE(host::describe_faults(report(fin)).find("1 edges with three"), std::string::npos);
}

TEST(Clean, refuses_with_one_sentence) {
  const std::vector<float> vertices = {0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::vector<float> poisoned = vertices;
  poisoned[5] = std::nanf("");
  for (const host::MeshResult& result :
       {host::clean_mesh(poisoned, {0, 1, 2}, "thing"), host::clean_mesh(vertices, {0, 1, 3}, "thing"),
        host::clean_mesh(vertices, {}, "thing"), host::clean_mesh({}, {0, 1, 2}, "thing"),
        host::clean_mesh(vertices, {0, 1, 1}, "thing")}) {
    EXPECT_FALSE(result);
    EXPECT_NE(result.error.find("\"thing\""), std::string::npos);
    EXPECT_EQ(result.error.find('\n'), std::string::npos);
    EXPECT_TRUE(result.mesh.vertices.empty());
  }
}

TEST(Ply, holds_exactly_the_points) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "points.ply";
  const Points points = {1, 2, 3, -4, 5.5f, 1e-7f};
  host::write_points_ply(path, points);
  const std::string text = content(path), end = "end_header\n";
  EXPECT_EQ(text.find("ply\nformat binary_little_endian 1.0\nelement vertex 2\n"), 0u);
  const size_t data = text.find(end) + end.size();
  ASSERT_EQ(text.size(), data + 24);
  float back[6];
  std::memcpy(back, text.data() + data, 24);
  EXPECT_EQ(Points(back, back + 6), points);
  EXPECT_EQ(files_in(folder), 1u);  // no partial file left
}

TEST(Ply, failure_is_a_sentence_and_leaves_what_was_there) {
  const tests::TemporaryFolder folder;
  EXPECT_THROW(host::write_points_ply(folder / "no/such/folder/points.ply", {1, 2, 3}), host::Failure);
  std::filesystem::create_directories(folder / "taken");
  EXPECT_THROW(host::write_points_ply(folder / "taken", {1, 2, 3}),
               host::Failure);  // a folder has that name, so renaming fails
  EXPECT_EQ(files_in(folder), 1u);
}

// A box of 0.4 x 0.1 x 0.1 whose edges may be 0.05 long: still closed, as large as before, and no edge longer.
TEST(Mesh, short_edges_keep_the_surface) {
  const float size[3] = {0.4f, 0.1f, 0.1f};
  const host::Mesh box = host::make_box(size), fine = host::with_short_edges(box, 0.05);
  const host::MeshResult cleaned = host::clean_mesh(fine.vertices, fine.indices, "box");
  EXPECT_TRUE(cleaned.report.watertight() && cleaned.report.manifold());
  EXPECT_EQ(cleaned.report.merged_vertices, 0u) << "neighbours share the middle of their edge";
  EXPECT_NEAR(host::signed_volume(fine), 0.004, 1e-8);
  for (size_t i = 0; i < fine.indices.size(); ++i) {
    const float *a = &fine.vertices[3 * fine.indices[i]],
                *b = &fine.vertices[3 * fine.indices[i % 3 == 2 ? i - 2 : i + 1]];
    EXPECT_LE(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 0.05f + 1e-6f);
  }
}

}  // namespace
}  // namespace sandglass::test
