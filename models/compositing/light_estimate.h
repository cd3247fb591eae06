// The light that the library estimates in a shot, and the camera's images that it is given.
#pragma once

#include <cstdint>
#include <string>

#include "models/compositing/surroundings.h"
#include "models/files/image.h"
#include "models/lighting/room_light.h"

namespace sandglass::host {

class LightEstimate {
 public:
  LightEstimate(const std::string& file, sandglass_isa isa) : light_(file, true, isa) {}

  // What the camera sees of its surroundings, taken at a time; valid until the next call.
  const sandglass_camera_image* take(const Surroundings& room, const ShotCamera& camera, uint64_t time_ns);
  // Runs the estimate of the image taken last to its end.
  void finish() { light_.follow(image_); }

  sandglass_light* handle() const { return light_.handle(); }
  bool valid() const { return light_.now().filtered.valid != 0; }
  ShotLight light() const;

 private:
  RoomLight light_;
  Picture picture_;
  sandglass_camera_image image_ = {};
};

// The shipped network, or empty where there is none.
std::string shipped_light_network();

}  // namespace sandglass::host
