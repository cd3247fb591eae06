// The ambient part of a baked shadow (runtime/asset/shadow.fbs): what an object hides of each cell of light, as a few
// textures of bytes that are mixed for any light.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "models/baking/cell_visibility.h"
#include "runtime/math/shadow_rectangle.h"

namespace sandglass::host {

struct AmbientPart {
  uint32_t components = 0;  // 0: there is none
  FloorSquare square;       // in the unit of the traced mesh
  std::vector<float> mixing;
  std::vector<int8_t> texels;
  double rmse = 0;
};

// Twice the object's height, and at least its height beyond its footprint.
FloorSquare ambient_square(const ShadowBox& box, uint32_t side);

// The components of `hidden` (trace_hidden_cells) in the order of their weight. At most `components`, fewer where the
// object needs fewer.
AmbientPart find_components(const FloorSquare& square, std::span<const float> hidden, uint32_t components);

}  // namespace sandglass::host
