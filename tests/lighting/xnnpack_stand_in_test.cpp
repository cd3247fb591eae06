// The lighting network by XNNPACK's generation since 2023, with a stand-in for it. Each operator is created, reshaped
// once, set up with the workspace that it asked for, and run. The output is that of the file's network. All memory is
// from the region and is given back. What is not possible is refused with a sentence.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>

#include "models/files/failure.h"
#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"
#include "models/work/random.h"
#include "platform/xnnpack.h"
#include "tests/lighting/byte_network.h"
#include "tests/lighting/float_network.h"
#include "tests/toolchains/stand_ins/xnnpack/calls.h"

namespace sandglass::host {
namespace {

using xnnpack_stand_in::Call;
constexpr int k_width = 32, k_height = 64;

std::vector<uint8_t> noise() {
  std::vector<uint8_t> rgb(size_t{3} * k_width * k_height);
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(256 * random_unit(i));
  return rgb;
}

const std::vector<uint8_t>& file() {
  static const std::vector<uint8_t> bytes = light_file_bytes(random_light_file(7));
  return bytes;
}

std::vector<float> features_of(sandglass_light_backend backend) {
  LightRunner runner(file(), "random", SANDGLASS_ISA_AUTOMATIC, k_width, k_height, backend);
  runner.run(noise());
  return runner.features();
}

TEST(XnnpackStandIn, OperatorsAreCreatedReshapedSetUpAndRunInThisOrder) {
  xnnpack_stand_in::g_asked_count = 0;
  features_of(SANDGLASS_LIGHT_BACKEND_XNNPACK_F32);
  ASSERT_LT(xnnpack_stand_in::g_asked_count, xnnpack_stand_in::k_call_capacity);
  ASSERT_EQ(xnnpack_stand_in::g_asked[0].call, Call::initialize);
  std::map<const void*, std::string> life;  // one letter for each call of an operator; addresses are used again
  uint32_t complete = 0, probes = 0;
  for (size_t i = 1; i < xnnpack_stand_in::g_asked_count; ++i) {
    const auto [call, op] = xnnpack_stand_in::g_asked[i];
    std::string& calls = life[op];
    calls += "icrsxd"[static_cast<int>(call)];
    if (call != Call::remove) continue;
    if (calls == "cd") {
      ++probes;  // it finds out whether the region is used
    } else {
      ASSERT_EQ(calls.substr(0, 2), "cr");
      ASSERT_EQ(calls.size() % 2, 1u);
      for (size_t k = 2; k + 1 < calls.size(); k += 2) ASSERT_EQ(calls.substr(k, 2), "sx");
      ASSERT_GE(calls.size(), 5u) << "an operator that never ran";
      ++complete;
    }
    life.erase(op);
  }
  EXPECT_EQ(probes, 1u);
  EXPECT_EQ(complete, 1u + 2 * k_dense_layer_count + k_transition_count);
  EXPECT_TRUE(life.empty()) << "an operator that was not given back";
  EXPECT_EQ(xnnpack_region_used(), 0u);
}

TEST(XnnpackStandIn, InFloatIsTheFileWithoutRounding) {
  const std::vector<float> features = features_of(SANDGLASS_LIGHT_BACKEND_XNNPACK_F32);
  const LightFile random = random_light_file(7);
  const tests::Map<double> map = tests::last_map<double>(random, noise(), k_width, k_height);
  double worst = 0;
  for (int c = 0; c < map.channels; ++c) {
    double sum = 0;
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) sum += map.at(x, y, c);
    const auto i = static_cast<size_t>(c);
    const double scale = static_cast<double>(random.feature_scale[i]);
    const double truth = scale * (sum / (map.width * map.height)) + static_cast<double>(random.feature_shift[i]);
    worst = std::max(worst, std::fabs(static_cast<double>(features[i]) - truth) / (255 * std::fabs(scale)));
  }
  EXPECT_LE(worst, 1e-3);
}

TEST(XnnpackStandIn, InFloatIsTheFloatNetworkOfAFileThatHasIt) {
  tests::expect_float_network(noise(), k_width, k_height);
}

TEST(XnnpackStandIn, InBytesIsTheOwnNetworkToTheBit) {
  EXPECT_EQ(features_of(SANDGLASS_LIGHT_BACKEND_XNNPACK_INT8), features_of(SANDGLASS_LIGHT_BACKEND_OWN));
}

TEST(XnnpackStandIn, ItsRegionBoundsWhatItTakes) {
  std::vector<std::unique_ptr<LightRunner>> lights;
  const auto another = [&] {
    lights.push_back(std::make_unique<LightRunner>(file(), "random", SANDGLASS_ISA_AUTOMATIC, k_width, k_height,
                                                   SANDGLASS_LIGHT_BACKEND_XNNPACK_F32));
  };
  another();
  const uint64_t used = xnnpack_region_used();
  EXPECT_GT(2 * used, k_xnnpack_region_bytes);  // there is no room for a second
  try {
    another();
    FAIL() << "more than the region holds";
  } catch (const Failure& failure) {
    EXPECT_NE(std::string(failure.what()).find("full"), std::string::npos) << failure.what();
  }
  EXPECT_EQ(xnnpack_region_used(), used);
  lights.clear();
  EXPECT_EQ(xnnpack_region_used(), 0u);
  another();  // in the pieces that were given back
  EXPECT_EQ(xnnpack_region_used(), used);
}

TEST(XnnpackStandIn, WhatItDoesNotHaveIsRefused) {
  xnnpack_stand_in::g_create_failures = 1;  // the probe
  for (int i = 0; i < 2; ++i) {
    try {
      features_of(SANDGLASS_LIGHT_BACKEND_XNNPACK_F32);
      FAIL();
    } catch (const Failure& failure) {
      EXPECT_NE(std::string(failure.what()).find("does not have the operators"), std::string::npos) << failure.what();
    }
    EXPECT_EQ(xnnpack_region_used(), 0u);
    xnnpack_stand_in::g_create_failures = 1;
  }
  xnnpack_stand_in::g_create_failures = 0;
}

TEST(XnnpackStandIn, AnAppThatWasFirstIsToldSo) {
  xnnpack_stand_in::g_app_was_first = true;
  try {
    features_of(SANDGLASS_LIGHT_BACKEND_XNNPACK_INT8);
    FAIL() << "memory without a bound";
  } catch (const Failure& failure) {
    EXPECT_NE(std::string(failure.what()).find("initialised XNNPACK first"), std::string::npos) << failure.what();
  }
  xnnpack_stand_in::g_app_was_first = false;
  EXPECT_EQ(features_of(SANDGLASS_LIGHT_BACKEND_XNNPACK_INT8).size(), size_t{k_light_features});
}

}  // namespace
}  // namespace sandglass::host
