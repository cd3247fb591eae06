// The light that the library estimates from the camera's image: the network's file, the handle for the frame, and the
// image that it is given.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/compositing/surroundings.h"
#include "models/files/aligned_bytes.h"
#include "models/work/block.h"
#include "sandglass/light.h"

namespace sandglass::host {

class LightEstimate {
 public:
  LightEstimate(const std::string& file, sandglass_isa isa);  // a Failure names what is wrong
  LightEstimate(const LightEstimate&) = delete;
  LightEstimate& operator=(const LightEstimate&) = delete;

  // What the camera sees of its surroundings, taken at a time; valid until the next call.
  const sandglass_camera_image* take(const Surroundings& room, const ShotCamera& camera, uint64_t time_ns);
  // The image taken last, estimated to the end.
  void finish();

  sandglass_light* handle() const { return light_; }
  uint64_t bytes() const { return bytes_; }
  bool valid() const;
  ShotLight light() const;

 private:
  AlignedBytes file_;
  Block block_;
  uint64_t bytes_ = 0;
  sandglass_light* light_ = nullptr;
  std::vector<uint8_t> pixels_;
  sandglass_camera_image image_ = {};
};

// The shipped network, or empty where there is none.
std::string shipped_light_network();

}  // namespace sandglass::host
