// The lighting network by XNNPACK's generation since 2023, with a stand-in for it. Each operator is created, reshaped
// once, set up with the workspace that it asked for, and run. The output is that of the file's network. All memory is
// from the region and is given back. What is not possible is refused with a sentence.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>

#include "platform/xnnpack.h"
#include "tests/light/float_network.h"
#include "tests/light/network_checks.h"
#include "tests/refusal.h"
#include "tests/toolchains/stand_ins/xnnpack/calls.h"

namespace sandglass::host {
namespace {

using xnnpack_stand_in::Call;
constexpr int k_width = 32, k_height = 64;

std::vector<uint8_t> noise() { return tests::noise(k_width, k_height); }

std::vector<float> features_of(sandglass_estimator_backend backend) {
  return tests::features_of(random_light_file(7), backend, noise(), k_width, k_height);
}

TEST(XnnpackStandIn, OperatorsAreCreatedReshapedSetUpAndRunInThisOrder) {
  xnnpack_stand_in::g_asked_count = 0;
  features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32);
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
  tests::expect_unrounded(random_light_file(7), features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32), noise(), k_width,
                          k_height);
}

TEST(XnnpackStandIn, InFloatIsTheFloatNetworkOfAFileThatHasIt) {
  tests::expect_float_network(noise(), k_width, k_height);
}

TEST(XnnpackStandIn, InBytesIsTheOwnNetworkToTheBit) {
  EXPECT_EQ(features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8), features_of(SANDGLASS_ESTIMATOR_BACKEND_OWN));
}

TEST(XnnpackStandIn, ItsRegionBoundsWhatItTakes) {
  std::vector<std::unique_ptr<LightRunner>> lights;
  const auto another = [&] {
    lights.push_back(std::make_unique<LightRunner>(light_file_bytes(random_light_file(7)), "random",
                                                   SANDGLASS_ISA_AUTOMATIC, k_width, k_height,
                                                   SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32));
  };
  another();
  const uint64_t used = xnnpack_region_used();
  EXPECT_GT(2 * used, k_xnnpack_region_bytes);  // there is no room for a second
  const std::string full = tests::refusal_of(another);
  EXPECT_NE(full.find("full"), std::string::npos) << full << ": more than the region holds";
  EXPECT_EQ(xnnpack_region_used(), used);
  lights.clear();
  EXPECT_EQ(xnnpack_region_used(), 0u);
  another();  // in the pieces that were given back
  EXPECT_EQ(xnnpack_region_used(), used);
}

TEST(XnnpackStandIn, WhatItDoesNotHaveIsRefused) {
  xnnpack_stand_in::g_create_failures = 1;  // the probe
  for (int i = 0; i < 2; ++i) {
    const std::string said = tests::refusal_of([] { features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_F32); });
    EXPECT_NE(said.find("does not have the operators"), std::string::npos) << said;
    EXPECT_EQ(xnnpack_region_used(), 0u);
    xnnpack_stand_in::g_create_failures = 1;
  }
  xnnpack_stand_in::g_create_failures = 0;
}

TEST(XnnpackStandIn, AnAppThatWasFirstIsToldSo) {
  xnnpack_stand_in::g_app_was_first = true;
  const std::string said = tests::refusal_of([] { features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8); });
  EXPECT_NE(said.find("initialised XNNPACK first"), std::string::npos) << said << ": memory without a bound";
  xnnpack_stand_in::g_app_was_first = false;
  EXPECT_EQ(features_of(SANDGLASS_ESTIMATOR_BACKEND_XNNPACK_INT8).size(), size_t{k_light_features});
}

}  // namespace
}  // namespace sandglass::host
