// Runs the library's shadow on a workstation: owns its memory and computes whole textures at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "models/baking/truth.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

class ShadowRunner {
 public:
  // Throws a Failure with the library's sentence when the library refuses the file. `name` is what the sentence calls
  // the file.
  ShadowRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa, sandglass_shadow_mode mode);

  // Computes the whole texture of `light`. The result points into the shadow's own memory.
  sandglass_texture texture(const Direction& light);
  // Of that texture: how many texels the network was asked for.
  uint32_t evaluated() const { return shadow_.evaluated(); }
  // Computes the whole ambient shadow in the light of `cells`, in the object's frame.
  std::vector<uint8_t> ambient(const std::array<double, SANDGLASS_LIGHT_CELLS>& cells);
  // CPU time of one ambient shadow on this machine (the median of some), in ms.
  double ambient_ms();
  sandglass_shadow* handle() const { return shadow_.get(); }

 private:
  cpp::Shadow shadow_;
};

}  // namespace sandglass::host
