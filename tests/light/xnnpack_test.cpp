// The back ends with the installed XNNPACK. In float they give the file's network without any rounding, or the float
// network that the file has. In bytes they give what the library's own kernels give. Units are small, an estimate over
// frames calls no malloc. The same holds on ARM, under emulation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "models/lighting/light_runner.h"
#include "models/work/random.h"
#include "platform/virtual_clock.h"
#include "platform/xnnpack.h"
#include "sandglass/sandglass.hpp"
#include "tests/counting_allocator.h"
#include "tests/light/float_network.h"
#include "tests/light/light_fixture.h"
#include "tests/light/network_checks.h"

namespace sandglass::host {
namespace {

constexpr int k_width = 64, k_height = 32;

using tests::noise;

TEST(Xnnpack, InFloatIsTheFileWithoutRounding) {
  const LightFile file = random_light_file(7);
  const std::vector<uint8_t> rgb = noise(k_width, k_height);
  tests::expect_unrounded(file,
                          tests::features_of(file, SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32, rgb, k_width, k_height),
                          rgb, k_width, k_height);
}

TEST(Xnnpack, InFloatIsTheFloatNetworkOfAFileThatHasIt) {
  tests::expect_float_network(noise(k_width, k_height), k_width, k_height);
}

TEST(Xnnpack, InBytesDoesNotReadTheFloatNetwork) {
  const std::vector<uint8_t> rgb = noise(k_width, k_height);
  LightFile file = random_light_file(7);
  const auto features_of = [&] {
    return tests::features_of(file, SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8, rgb, k_width, k_height);
  };
  const std::vector<float> expected = features_of();
  file.float_parameters.assign(k_light_float_parameters, 0.5f);
  EXPECT_EQ(features_of(), expected);
}

// Weights as large as the reader allows. Infinities and NaN occur in between but must not come out.
TEST(Xnnpack, ForgedFloatNetworksSayNumbers) {
  const std::vector<uint8_t> rgb = noise(32, 32);
  LightFile file = random_light_file(7);
  for (const double share : {1.0, 0.5, 0.0}) {  // the share of positive numbers
    file.float_parameters.resize(k_light_float_parameters);
    for (size_t i = 0; i < file.float_parameters.size(); ++i)
      file.float_parameters[i] = random_unit(i) < share ? k_light_float_limit : -k_light_float_limit;
    LightRunner runner(light_file_bytes(file), "forged", SANDGLASS_ISA_AUTOMATIC, 32, 32,
                       SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32);
    for (const float value : tests::values_of(runner.run(rgb))) EXPECT_TRUE(value >= -1 && value <= 1) << value;
    for (const float feature : runner.features()) ASSERT_TRUE(std::isfinite(feature)) << feature;
  }
}

// For two networks: a random one, and the shipped one, in which some channels have multipliers of thousands.
class XnnpackInBytes : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(, XnnpackInBytes, testing::Bool(),
                         [](const auto& network) { return network.param ? "Shipped" : "Random"; });
TEST_P(XnnpackInBytes, IsTheOwnNetworkButForItsRounding) {
  const std::vector<uint8_t> rgb = noise(k_width, k_height);
  std::ifstream shipped(SANDGLASS_LIGHTS_DIR "/room.light", std::ios::binary);
  const std::vector<uint8_t> file = GetParam() ? std::vector<uint8_t>(std::istreambuf_iterator<char>(shipped), {})
                                               : light_file_bytes(random_light_file(7));
  const auto features_of = [&](sandglass_estimator_backend backend) {
    LightRunner runner(file, "network", SANDGLASS_ISA_AUTOMATIC, k_width, k_height, backend);
    runner.run(rgb);
    return runner.features();
  };
  LightRunner runner(file, "network", SANDGLASS_ISA_AUTOMATIC, k_width, k_height);
  const std::vector<float> own = features_of(SANDGLASS_ESTIMATOR_BACKEND_OWN),
                           features = features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8);
  double square = 0;
  for (size_t i = 0; i < own.size(); ++i) {
    const double scale = 255 * static_cast<double>(runner.asset().feature_scale[i]);
    if (scale == 0) continue;  // the file does not use this channel
    square += std::pow(static_cast<double>(features[i] - own[i]) / scale, 2);
  }
  const double rms = std::sqrt(square / static_cast<double>(own.size()));
  EXPECT_LE(rms, 0.01);
#if defined(__x86_64__)
  EXPECT_EQ(own, features) << "README and estimator.h say: to the bit";
#endif
  std::printf("root mean square of 1024 features' differences: %.2g of their range\n", rms);
}

TEST(Xnnpack, UnitsAreAsSmallAsTheOwnAndMayRunInAnyOrder) {
  LightRunner runner(light_file_bytes(random_light_file(7)), "random", SANDGLASS_ISA_AUTOMATIC, 256, 192,
                     SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32);
  const LightNetwork& net = *runner.network();
  for (uint32_t unit = 0; unit < net.units; ++unit) EXPECT_LE(light_unit(net, unit).items, k_light_unit_macs / 1000);
  if (!SANDGLASS_EMULATED) tests::expect_any_order(&runner, noise(256, 192));
}

// Run by float_network.sh, which makes the file.
TEST(Xnnpack, InFloatIsPyTorchs) {
  const char* path = std::getenv("SANDGLASS_FLOAT_NETWORK");
  if (path == nullptr) GTEST_SKIP() << "SANDGLASS_FLOAT_NETWORK is not set to what `quantise.py --keep-float` wrote";
  std::ifstream made(path, std::ios::binary);
  LightRunner runner(std::vector<uint8_t>(std::istreambuf_iterator<char>(made), {}), path, SANDGLASS_ISA_AUTOMATIC, 256,
                     192, SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32);
  tests::expect_pytorch(SANDGLASS_EXCERPTS_DIR,
                        [&](const std::vector<uint8_t>& rgb) { return tests::values_of(runner.run(rgb)); });
}

uint64_t weights() {
  const LightFile file = random_light_file(7);
  uint64_t count = file.stem.weights.size();
  for (const auto* convolutions : {&file.narrow, &file.wide, &file.transition})
    for (const ByteConvolution& c : *convolutions) count += c.weights.size();
  return count;
}

// As in an app: chosen in the description, and run in frames with a small budget.
class XnnpackInFrames : public testing::TestWithParam<sandglass_estimator_backend> {};
INSTANTIATE_TEST_SUITE_P(, XnnpackInFrames,
                         testing::Values(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32,
                                         SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8),
                         [](const auto& backend) {
                           return backend.param == SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32 ? "F32" : "Int8";
                         });
TEST_P(XnnpackInFrames, AnEstimateTakesSeveralAndNoMemory) {
  const uint64_t before = xnnpack_region_used();
  {
    sandglass_estimator_desc desc = tests::describe_light();
    desc.smoothing = 0;
    Estimator own, light;
    ASSERT_TRUE(own.create(desc));
    desc.backend = GetParam();
    const Status status = light.create(desc);
    ASSERT_TRUE(status) << status.reason;
    const uint64_t used = xnnpack_region_used();
    // The region holds all weights, and no second copy of them.
    const uint64_t held = weights() * (GetParam() == SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32 ? sizeof(float) : 1);
    EXPECT_GT(used, before + held);
    EXPECT_LT(used, before + 3 * held / 2);
    std::printf("of the region: %.1f MiB\n", static_cast<double>(used - before) / (1 << 20));

    VirtualClock time;
    time.step_ns = 20'000;  // the cost of a unit
    sandglass_scene_desc scene_desc = sandglass::scene_desc();
    scene_desc.clock = virtual_clock(&time);
    scene_desc.granular.particle_radius = 0.01f;
    scene_desc.granular.particle_capacity = scene_desc.granular.grain_capacity = 1;
    Scene scene;
    ASSERT_TRUE(scene.create(scene_desc));
    tests::TestImage picture(4);
    picture.image.timestamp_ns = 5;
    sandglass_frame_input input = sandglass::frame_input();
    input.time_step = 1.0f / 60.0f;
    input.budget_ns = 4'000'000;
    input.estimator = light.get();
    input.camera = &picture.image;
    sandglass_frame_report report = sandglass::frame_report();
    uint32_t frames = 0;
    start_counting_allocations();
    do {
      ASSERT_TRUE(scene.frame(input, &report));
      input.camera = nullptr;
      ASSERT_LE(report.time.elapsed_ns,
                std::max(report.time.budget_ns, report.time.mandatory_ns) + report.time.last_unit_ns);
    } while (report.estimator.changed == 0 && ++frames < 100);
    EXPECT_EQ(stop_counting_allocations(), 0u);
    EXPECT_EQ(xnnpack_region_used(), used);
    EXPECT_GE(frames, 3u);
    EXPECT_LT(frames, 30u);

    // It is the own network's estimate of that image, except for the rounding to bytes.
    ASSERT_TRUE(own.estimate(picture.image));
    const sandglass_estimator_light a = own.light(), b = light.light();
    EXPECT_EQ(b.valid, 1u);
    double cosine = 0;
    for (int i = 0; i < 3; ++i) {
      cosine += static_cast<double>(a.direction[i]) * static_cast<double>(b.direction[i]);
      EXPECT_NEAR(a.ambient[i], b.ambient[i], 0.1f);
    }
    EXPECT_GT(cosine, 0.9);
  }
  EXPECT_EQ(xnnpack_region_used(), before) << "the owner must give back what was taken";
}

}  // namespace
}  // namespace sandglass::host
