// The runtime's shadow on a workstation: owns the block and runs whole textures.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "models/baking/truth.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

class ShadowRunner {
 public:
  // A Failure with the library's sentence where it refuses; `name` is what the sentence calls the file. `threshold`
  // below 0: the library's default.
  ShadowRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa, sandglass_shadow_mode mode,
               int32_t threshold = -1);

  // Computes the texture of `light` to its end; the view of the runtime's own memory.
  sandglass_shadow_texture texture(const Direction& light);
  sandglass_shadow* handle() const { return shadow_.get(); }

 private:
  cpp::Shadow shadow_;
};

}  // namespace sandglass::host
