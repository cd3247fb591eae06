// A light on a network of random weights, in a block with guard bytes, and images for it.
#pragma once

#include <cstdint>
#include <vector>

#include "sandglass/light.h"

namespace sandglass::tests {

// The file of the random network, aligned; the same for every caller.
struct LightFileBytes {
  std::vector<uint64_t> words;
  uint64_t bytes = 0;
  const uint8_t* data() const { return reinterpret_cast<const uint8_t*>(words.data()); }
  uint8_t* data() { return reinterpret_cast<uint8_t*>(words.data()); }
};
const LightFileBytes& random_light();

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
  sandglass_light_estimate get() const;
  sandglass_light_estimate latest() const;
  bool guards_intact() const;

  std::vector<uint8_t> memory;
  uint8_t* block = nullptr;
  uint64_t bytes = 0;
  sandglass_light* light = nullptr;
};

}  // namespace sandglass::tests
