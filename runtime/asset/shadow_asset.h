// A baked shadow file as the runtime sees it: checked from the first byte to the last, then pointers into the app's
// bytes. Only shadow_asset.cpp knows FlatBuffers.
#pragma once

#include <cstdint>

#include "kernels/int8.h"
#include "runtime/math/shadow_rectangle.h"
#include "sandglass/shadow.h"

namespace sandglass {

// What a bake writes. Version 1 has neither an ambient shadow nor a surface; it is read too.
constexpr uint32_t k_shadow_asset_version = 2;
constexpr uint32_t k_shadow_asset_oldest = 1;
constexpr uint32_t k_frequencies_limit = 16;
constexpr uint32_t k_ambient_side_limit = 256;  // texels; sides are multiples of 16
constexpr uint32_t k_surface_coefficients = 9;

struct AssetLayer {
  const int8_t* weights;
  const int32_t* bias;
  const float* multiplier;
};

struct AmbientAsset {
  uint32_t side;
  double half;          // metres
  uint32_t components;  // 0: the file has none
  const float* mixing;
  const int8_t* texels;
  float rmse;
};

struct SurfaceAsset {
  uint32_t vertices;  // 0: the file has none
  float low[3], step;
  const uint16_t* positions;
  const int8_t* normals;
  const float* steps;
  const int8_t* transfer;
};

struct ShadowAsset {
  uint32_t version;
  const char* name;
  double origin[3];
  ShadowBox box;
  double angular_diameter, polar_max;
  PlaneRule plane;
  uint32_t texel_frequencies, light_frequencies, width, layers;
  const float* first_weights;
  const float* first_bias;
  float first_step;
  AssetLayer layer[k_shadow_layers_limit];
  AssetLayer last;
  float rmse_float, rmse_int8;
  uint32_t validated_lights;
  uint64_t seed;
  const float* float_parameters;  // null: the file has none
  uint32_t float_parameter_count;
  AmbientAsset ambient;
  SurfaceAsset surface;

  uint32_t texel_inputs() const { return 1 + 2 * texel_frequencies; }
  uint32_t light_inputs() const { return 1 + 2 * light_frequencies; }
  uint32_t inputs() const { return 2 * texel_inputs() + 3 * light_inputs(); }
};

// `bytes` is aligned to 8. Refuses, with one sentence, everything but a whole, undamaged file of a version that is
// read, whose numbers the kernels can run on blindly.
sandglass_status open_shadow_asset(const void* bytes, uint64_t count, ShadowAsset* asset, const char** reason);

}  // namespace sandglass
