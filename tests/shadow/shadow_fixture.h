// Files of networks with random weights, on which the runtime's tests run without any baking.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "sandglass/shadow.h"
#include "tests/asset_file.h"
#include "tests/guarded_block.h"

namespace sandglass::tests {

struct RandomShadow {
  uint32_t width = 32, layers = 2, texel_frequencies = 4, light_frequencies = 2;
  uint64_t seed = 1;
  float spread = 1;          // spread of the first layer's weights
  int8_t forced_weight = 0;  // if not 0, put into the first hidden layer
  float forced_first = 0;    // if not 0 (NaN, for example), put into the first layer
  uint16_t version = 1;
  // An ambient shadow with random components, and a surface. Only files of version 2 have them.
  uint32_t ambient_side = 0, components = 0;
  uint32_t surface_vertices = 0;
  bool unsorted_surface = false;
  float forced_mixing = 0;      // if not 0, put into the first component
  uint32_t missing_texels = 0;  // that the file lacks
};

AssetFile make_shadow_file(const RandomShadow& what);

sandglass_shadow_desc describe(const AssetFile& file, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC,
                               sandglass_shadow_mode mode = SANDGLASS_SHADOW_ADAPTIVE);

// The sets that a hash is taken on. Under emulation each core has a test of its own, which takes the core's own set.
std::vector<sandglass_isa> golden_sets();

// The value at (x, y) between those that `texel` gives at whole numbers.
template <class Texel>
double bilinear(Texel&& texel, double x, double y) {
  const double u = std::floor(x), v = std::floor(y);
  return std::lerp(std::lerp(texel(u, v), texel(u + 1, v), x - u),
                   std::lerp(texel(u, v + 1), texel(u + 1, v + 1), x - u), y - v);
}

// A shadow and its memory.
struct LiveShadow {
  explicit LiveShadow(const sandglass_shadow_desc& desc);
  void light(float x, float y, float z);
  void finish();
  void shade(float x, float y, float z) {  // the whole texture of this light
    light(x, y, z);
    finish();
  }
  sandglass_texture texture(uint32_t light = 0) const;
  uint32_t evaluated(uint32_t light = 0) const { return sandglass_shadow_evaluated(shadow, light); }
  std::vector<uint8_t> coverage(uint32_t light = 0) const;

  test::GuardedBlock block;
  sandglass_shadow* shadow = nullptr;
};

}  // namespace sandglass::tests
