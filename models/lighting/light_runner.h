// The runtime's lighting network as a workstation uses it: whole images at once, or unit by unit for measuring.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "models/host/aligned_bytes.h"
#include "models/host/block.h"
#include "runtime/lighting/network.h"

namespace sandglass::host {

class LightRunner {
 public:
  // `file` as light_file_bytes makes it; a Failure that names it for anything else. Sides: 32 to 256 in steps of 32.
  LightRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC,
              uint32_t width = 256, uint32_t height = 192);
  LightRunner(const LightRunner&) = delete;
  LightRunner& operator=(const LightRunner&) = delete;

  LightOutputs run(std::span<const uint8_t> rgb);
  std::vector<float> features() const;
  LightNetwork* network() { return network_; }
  const LightAsset& asset() const { return network_->asset; }

 private:
  AlignedBytes file_;
  Block block_;
  LightNetwork* network_;
};

}  // namespace sandglass::host
