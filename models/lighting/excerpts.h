// 56 images with the outputs of the shipped network's float original (PyTorch, float_network.py): excerpts of seven
// made-up rooms, on which the network was neither trained nor calibrated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "models/lighting/light_net.h"

namespace sandglass::host {

struct Excerpt {
  std::string name;
  std::vector<uint8_t> rgb;  // 256 x 192
  LightValues values;        // PyTorch's output
};

// Reads every `step`th line of `folder`/estimates.csv. Throws a Failure if it is another folder, or if the pixels are
// not those that PyTorch saw, because decoders of JPEG differ.
std::vector<Excerpt> read_excerpts(const std::string& folder, size_t step = 1);

}  // namespace sandglass::host
