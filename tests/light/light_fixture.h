// A light on a network of random weights, and images for it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/asset_file.h"

namespace sandglass::tests {

// The file of the random network; the same for every caller.
const AssetFile& random_light();

sandglass_estimator_desc describe_light();

// An image, RGB by default: smooth blobs of colour that differ for every seed, seen by the network's own camera.
struct TestImage {
  sandglass_camera_image image;
  std::vector<uint8_t> bytes;
  explicit TestImage(uint64_t seed, uint32_t width = 256, uint32_t height = 192);
};

// A light on the random network.
struct LiveLight : Estimator {
  explicit LiveLight(const sandglass_estimator_desc& desc = describe_light()) { EXPECT_TRUE(create(desc)); }
  void estimate(const sandglass_camera_image& image) { EXPECT_TRUE(Estimator::estimate(image)); }
  // Runs what is left of an estimate.
  void finish() { sandglass_estimator_run(get(), UINT32_MAX); }
};

}  // namespace sandglass::tests
