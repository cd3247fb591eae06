// The shadow of a scene's sand: made from its description, turned with the light, handed to the frame, and copied for
// the pictures.
#pragma once

#include <vector>

#include "models/simulation/floor_shadow.h"
#include "models/simulation/scene_file.h"
#include "models/work/block.h"
#include "sandglass/pile_shadow.h"

namespace sandglass::host {

class PileShadow {
 public:
  PileShadow(const PileShadowTrack& track, sandglass_isa isa);  // a Failure with the library's own sentence

  void set_light(Vec3 towards);
  sandglass_pile_shadow* handle() const { return shadow_; }
  uint64_t bytes() const { return bytes_; }

  // As it is now. `on_sand`: what falls on the sand itself.
  FloorShadow drawn(bool on_sand) const;

 private:
  Block block_;
  uint64_t bytes_ = 0;
  sandglass_pile_shadow* shadow_ = nullptr;
};

}  // namespace sandglass::host
