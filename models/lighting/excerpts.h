// 56 images with the outputs of the shipped network's float original (PyTorch, float_network.py): excerpts of seven
// made-up rooms, on which the network was neither trained nor calibrated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/light/network/network.h"

namespace sandglass::host {

// The unit direction in the camera's frame, light, ambient, contrast.
using LightValues = std::array<float, k_light_heads>;

// Medians over images, with a[i] compared to b[i]: of the angle between the directions, and of the greatest difference
// among the colours' channels and the contrast.
struct LightDifference {
  double angle_deg, other;
};
LightDifference median_difference(std::span<const LightValues> a, std::span<const LightValues> b);

struct Excerpt {
  std::string name;
  std::vector<uint8_t> rgb;  // 256 x 192
  LightValues values;        // PyTorch's output
};

// Reads every `step`th line of `folder`/estimates.csv. Throws a Failure if it is another folder, or if the pixels are
// not those that PyTorch saw, because decoders of JPEG differ.
std::vector<Excerpt> read_excerpts(const std::string& folder, size_t step = 1);

}  // namespace sandglass::host
