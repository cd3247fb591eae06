// A light on a network of random weights, in a block with guard bytes, and images for it.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/light.h"
#include "tests/asset_file.h"
#include "tests/guarded_block.h"

namespace sandglass::tests {

// The file of the random network; the same for every caller.
const AssetFile& random_light();

sandglass_light_desc describe_light();

// An image, RGB by default: smooth blobs of colour that differ for every seed, seen by the network's own camera.
struct TestImage {
  sandglass_camera_image image;
  std::vector<uint8_t> bytes;
  explicit TestImage(uint64_t seed, uint32_t width = 256, uint32_t height = 192);
};

struct LiveLight {
  explicit LiveLight(const sandglass_light_desc& desc = describe_light());
  // Gives it the image and runs all units of the estimate.
  void estimate(const sandglass_camera_image& image);
  void finish();
  sandglass_light_estimate get() const;
  sandglass_light_estimate latest() const;

  test::GuardedBlock block;
  sandglass_light* light = nullptr;
};

}  // namespace sandglass::tests
