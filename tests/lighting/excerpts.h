// 56 excerpts of seven made-up rooms and what PyTorch says of them in float (models/lighting/excerpts).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "models/lighting/light_net.h"

namespace sandglass::host {

struct Excerpt {
  std::string name;
  std::vector<uint8_t> rgb;
  LightValues values;  // PyTorch's
};

// Of estimates.csv every `step`th; the bytes are those that PyTorch saw.
std::vector<Excerpt> excerpts(size_t step);

}  // namespace sandglass::host
