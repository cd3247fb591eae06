// Small bakes from end to end: the same file on any number of threads, and what is refused.
#include "models/baking/bake.h"

#include <gtest/gtest.h>

#include "models/files/aligned_bytes.h"
#include "models/files/atomic_file.h"
#include "models/mesh/generated.h"
#include "sandglass/shadow.h"
#include "tests/refusal.h"
#include "tests/temporary_folder.h"

namespace {

using namespace sandglass;
using namespace sandglass::host;
namespace fs = std::filesystem;
using tests::expect_refusal;

class Bake : public ::testing::Test {
 protected:
  tests::TemporaryFolder folder;
  std::string path(const std::string& name) const { return folder / name; }
};

BakeSettings tiny() {
  BakeSettings settings;
  settings.shape = {16, 1};
  settings.textures = 1;
  settings.steps = 20;
  settings.quantised_steps = 10;
  settings.batch = 512;
  settings.validation_lights = 4;
  settings.ambient.texels = 16;
  settings.ambient.rooms = 1;
  return settings;
}

TEST_F(Bake, SameFileOnAnyNumberOfThreads) {
  BakeSettings settings = tiny();
  bake(make_chair(), "chair", settings, path("one"), "");
  settings.threads = 3;
  bake(make_chair(), "chair", settings, path("three"), path("picture.png"));
  const std::string file = read_file(path("one"), "shadow");
  EXPECT_EQ(file, read_file(path("three"), "shadow"));
  EXPECT_TRUE(fs::exists(path("picture.png")));
  settings.seed = 2;
  bake(make_chair(), "chair", settings, path("other"), "");
  EXPECT_NE(file, read_file(path("other"), "shadow"));
}

// An older library reads it: a file without ambient shadow is one of version 1.
TEST_F(Bake, LeavesTheAmbientShadowOutWhereNoneIsWanted) {
  BakeSettings settings = tiny();
  settings.ambient.texels = 0;
  bake(make_chair(), "chair", settings, path("without"), "");
  const AlignedBytes file = read_aligned(path("without"), "shadow");
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  ASSERT_EQ(sandglass_shadow_inspect(file.data(), file.size(), &info, nullptr), SANDGLASS_OK);
  EXPECT_EQ(info.version, 1u);
  EXPECT_EQ(info.ambient_texels, 0u);
}

TEST_F(Bake, RefusesWhatItCannotBakeAndLeavesNoFile) {
  BakeSettings settings = tiny();
  const Mesh flat = {{0, 0, 0, 1, 0, 0, 0, 0, 1}, {0, 1, 2}};
  expect_refusal("flat", [&] { bake(flat, "flat", settings, path("out"), ""); });
  settings.polar_max = 80;
  expect_refusal("horizon", [&] { bake(make_chair(), "chair", settings, path("out"), ""); });
  EXPECT_TRUE(fs::is_empty(folder.path));
}

TEST(ShadowMetrics, SimilarityOfEqualTexturesIsOneAndOfOppositesLow) {
  std::vector<float> a(64 * 64), b(64 * 64);
  for (size_t i = 0; i < a.size(); ++i) {
    a[i] = static_cast<float>(i % 64 / 8 % 2);
    b[i] = 1 - a[i];
  }
  EXPECT_NEAR(structural_similarity(a, a, 64), 1, 1e-12);
  EXPECT_LT(structural_similarity(a, b, 64), 0.1);
}

}  // namespace
