// Images of which it is known what the shipped network's float original says (PyTorch, float_network.py): 56 excerpts
// of seven made-up rooms, that neither trained nor calibrated it.
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
  LightValues values;        // PyTorch's
};

// Of `folder`/estimates.csv every `step`th. A Failure where the folder is another, or the pixels are not those that
// PyTorch saw: decoders of JPEG differ.
std::vector<Excerpt> read_excerpts(const std::string& folder, size_t step = 1);

}  // namespace sandglass::host
