// The runtime's lighting network on a workstation: whole images at once, or unit by unit to measure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "models/files/aligned_bytes.h"
#include "models/work/block.h"
#include "runtime/light/network/network.h"

namespace sandglass::host {

class LightRunner {
 public:
  // `file` is as light_file_bytes makes it; a Failure names anything else. Sides are 32 to 256, in steps of 32.
  LightRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC,
              uint32_t width = 256, uint32_t height = 192,
              sandglass_estimator_backend backend = SANDGLASS_ESTIMATOR_BACKEND_OWN);
  ~LightRunner() { release_light_network(network_); }
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
