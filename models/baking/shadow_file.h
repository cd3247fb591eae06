// The file of a shadow that the runtime reads: a FlatBuffer, then its checksum.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/baking/ambient.h"
#include "models/baking/quantise.h"
#include "models/baking/surface.h"

namespace sandglass::host {

struct ShadowFile {
  std::string name;
  LightGeometry geometry;
  ByteNetwork network;
  double rmse_float = 0, rmse_int8 = 0;
  uint32_t validated_lights = 0;
  uint64_t seed = 0;
  std::vector<float> float_parameters;  // empty: the file holds none
  AmbientPart ambient = {};
  SurfacePart surface = {};
};

std::vector<uint8_t> shadow_file_bytes(const ShadowFile& file);

}  // namespace sandglass::host
