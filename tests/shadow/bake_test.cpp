// Small bakes from end to end: the same file on any number of threads and after an interruption, and what is refused.
#include "models/baking/bake.h"

#include <gtest/gtest.h>

#include "models/baking/checkpoint.h"
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
  settings.textures = 1, settings.steps = 20, settings.quantised_steps = 10, settings.batch = 512;
  settings.validation_lights = 4;
  settings.ambient.texels = 16, settings.ambient.rooms = 1;
  return settings;
}

TEST_F(Bake, SameFileOnAnyNumberOfThreads) {
  BakeSettings settings = tiny();
  bake(make_chair(), "chair", settings, path("one"), "", false);
  settings.threads = 3;
  bake(make_chair(), "chair", settings, path("three"), path("picture.png"), false);
  const std::string file = read_file(path("one"), "shadow");
  EXPECT_EQ(file, read_file(path("three"), "shadow"));
  EXPECT_TRUE(fs::exists(path("picture.png")));
  EXPECT_FALSE(fs::exists(path("one") + ".checkpoint"));
  settings.seed = 2;
  bake(make_chair(), "chair", settings, path("other"), "", false);
  EXPECT_NE(file, read_file(path("other"), "shadow"));
}

TEST_F(Bake, LeavesAFileThatItDidNotWrite) {
  BakeSettings settings = tiny();
  TrainingSet set;
  const std::string checkpoint = path("one") + ".checkpoint";
  save_checkpoint(checkpoint, 7, set, start_training(settings.shape, 1));  // of another bake
  const std::string before = read_file(checkpoint, "checkpoint");
  bake(make_chair(), "chair", settings, path("one"), "", false);
  EXPECT_EQ(read_file(checkpoint, "checkpoint"), before);
  write_file(path("two") + ".checkpoint", std::string("a person's notes"));
  expect_refusal("no checkpoint", [&] { bake(make_chair(), "chair", settings, path("two"), "", false); });
}

// A file without ambient shadow is one of version 1. Adding the ambient shadow later gives what a whole bake gives.
TEST_F(Bake, AddsTheAmbientShadowToAFileAndLeavesItsNetworkAsItIs) {
  BakeSettings settings = tiny();
  bake(make_chair(), "chair", settings, path("whole"), "", false);
  settings.ambient.texels = 0;
  bake(make_chair(), "chair", settings, path("parts"), "", false);
  const AlignedBytes old = read_aligned(path("parts"), "shadow");
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  ASSERT_EQ(sandglass_shadow_inspect(old.data(), old.size(), &info, nullptr), SANDGLASS_OK);
  EXPECT_EQ(info.version, 1u);
  EXPECT_EQ(info.ambient_texels, 0u);
  settings.ambient.texels = 16, settings.threads = 2;
  bake_ambient_only(make_chair(), "chair", settings, path("parts"), path("rooms.png"));
  EXPECT_EQ(read_file(path("parts"), "shadow"), read_file(path("whole"), "shadow"));
  EXPECT_TRUE(fs::exists(path("rooms.png")));
  expect_refusal("another size", [&] { bake_ambient_only(make_trefoil(), "knot", settings, path("parts"), ""); });
  EXPECT_EQ(read_file(path("parts"), "shadow"), read_file(path("whole"), "shadow"));
}

TEST_F(Bake, TrainingGoesOnFromACheckpointToTheSameBits) {
  const BakeSettings settings = tiny();
  const LightGeometry geometry = light_geometry(make_chair(), "chair", settings);
  const ShadowCaster caster(geometry.object.mesh, geometry.half_angle, {}, 1);
  ThreadPool pool(1);
  TrainingSet set;
  set.size = k_native_size, set.stride = 4, set.lights = ring_directions(geometry.polar_max, 16);
  uint32_t stop_after = 5;  // lights
  EXPECT_FALSE(trace_training_set(
      geometry, caster, pool, [&](uint32_t done) { return done < stop_after; }, &set));
  TrainingPlan plan;
  plan.float_steps = 12, plan.quantised_steps = 8, plan.batch = 512;
  TrainingState state = start_training({16, 1}, 1);
  save_checkpoint(path("checkpoint"), 7, set, state);

  TrainingSet resumed = set;
  resumed.values.clear();
  ASSERT_TRUE(load_checkpoint(path("checkpoint"), 7, &resumed, &state));
  EXPECT_EQ(resumed.values, set.values);
  for (TrainingSet* s : {&set, &resumed})
    EXPECT_TRUE(trace_training_set(
        geometry, caster, pool, [](uint32_t) { return true; }, s));
  EXPECT_EQ(resumed.values, set.values);

  for (const uint32_t stop : {3u, 12u, 15u}) {  // during, at the end of, and after the float steps
    Trainer trainer(set, plan, pool);
    TrainingState straight = start_training({16, 1}, 1), broken = start_training({16, 1}, 1);
    while (!trainer.finished(straight)) trainer.step(&straight);
    while (broken.step < stop) trainer.step(&broken);
    save_checkpoint(path("checkpoint"), 7, set, broken);
    TrainingState again = start_training({16, 1}, 9);
    ASSERT_TRUE(load_checkpoint(path("checkpoint"), 7, &set, &again));
    find_penumbra(&set);
    while (!trainer.finished(again)) trainer.step(&again);
    EXPECT_EQ(again.network.parameters, straight.network.parameters) << stop;
    EXPECT_EQ(again.float_network.parameters, straight.float_network.parameters) << stop;
    EXPECT_EQ(again.clips, straight.clips) << stop;
  }
}

TEST_F(Bake, RefusesCheckpointsThatAreDamagedOrOfAnotherBake) {
  TrainingSet set;
  set.values = {1, 2, 3};
  TrainingState state = start_training({8, 1}, 1);
  EXPECT_FALSE(load_checkpoint(path("none"), 1, &set, &state));
  save_checkpoint(path("checkpoint"), 1, set, state);
  expect_refusal("another mesh or other settings", [&] { load_checkpoint(path("checkpoint"), 2, &set, &state); });
  const std::string bytes = read_file(path("checkpoint"), "checkpoint");
  for (size_t cut = 0; cut < bytes.size(); cut += 97) {
    write_file(path("cut"), bytes.substr(0, cut));
    expect_refusal("damaged", [&] { load_checkpoint(path("cut"), 1, &set, &state); });
    std::string flipped = bytes;
    flipped[cut] = static_cast<char>(flipped[cut] ^ 4);
    write_file(path("flipped"), flipped);
    expect_refusal("", [&] { load_checkpoint(path("flipped"), 1, &set, &state); });
  }
}

TEST_F(Bake, RefusesWhatItCannotBakeAndLeavesNoFile) {
  BakeSettings settings = tiny();
  const Mesh flat = {{0, 0, 0, 1, 0, 0, 0, 0, 1}, {0, 1, 2}};
  expect_refusal("flat", [&] { bake(flat, "flat", settings, path("out"), "", false); });
  settings.polar_max = 80;
  expect_refusal("horizon", [&] { bake(make_chair(), "chair", settings, path("out"), "", false); });
  EXPECT_TRUE(fs::is_empty(folder.path));
}

TEST(ShadowMetrics, SimilarityOfEqualTexturesIsOneAndOfOppositesLow) {
  std::vector<float> a(64 * 64), b(64 * 64);
  for (size_t i = 0; i < a.size(); ++i) a[i] = static_cast<float>(i % 64 / 8 % 2), b[i] = 1 - a[i];
  EXPECT_NEAR(structural_similarity(a, a, 64), 1, 1e-12);
  EXPECT_LT(structural_similarity(a, b, 64), 0.1);
}

}  // namespace
