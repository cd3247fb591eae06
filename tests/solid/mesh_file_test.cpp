// Reading good and bad mesh files: each bad one gives one sentence that names the file.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "models/mesh/mesh.h"

namespace sandglass::test {
namespace {

std::string write(const std::string& name, const std::string& text) {
  const std::string path = (std::filesystem::path(testing::TempDir()) / ("sandglass_file_test_" + name)).string();
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

void expect_sentence(const std::string& path, const char* about) {
  const host::MeshResult result = host::load_mesh(path);
  EXPECT_FALSE(result) << path;
  EXPECT_NE(result.error.find(path), std::string::npos) << result.error;
  EXPECT_NE(result.error.find(about), std::string::npos) << result.error;
  EXPECT_EQ(result.error.find('\n'), std::string::npos) << result.error;
  EXPECT_TRUE(result.mesh.indices.empty());
}

TEST(MeshFile, missing_empty_and_folder) {
  expect_sentence("/no/such/mesh.obj", "does not exist");
  expect_sentence(write("empty.obj", ""), "is empty");
  expect_sentence(testing::TempDir(), "is not a file");
}

const char k_vertices[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

TEST(MeshFile, without_surface_is_refused) {
  expect_sentence(write("no_faces.obj", k_vertices), "no triangles");
  expect_sentence(write("infinite.obj", "v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n"), "inf");
  expect_sentence(write("degenerate.obj", std::string(k_vertices) + "f 1 2 2\n"), "degenerate");
  expect_sentence(write("cut_vertex.obj", "v 0 0 0\nv 1 0 0\nv 0 1"), "cut off");
}

TEST(MeshFile, non_manifold_ones_are_reported_not_refused) {
  const host::MeshResult result = host::load_mesh(
      write("fin.obj", std::string(k_vertices) + "v 2 2 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 1 2 5\n"));
  ASSERT_TRUE(result) << result.error;
  EXPECT_EQ(result.report.non_manifold_edges, 1u);
  EXPECT_EQ(result.report.boundary_edges, 2u);
  EXPECT_FALSE(result.report.watertight());
}

}  // namespace
}  // namespace sandglass::test
