// The shadow of a scene's sand. It is made from its description in the scene file, turned with the light, handed to the
// frame, and copied for the pictures.
#pragma once

#include <span>
#include <vector>

#include "models/simulation/floor_shadow.h"
#include "models/simulation/scene_file.h"
#include "models/work/block.h"
#include "sandglass/pile_shadow.h"

namespace sandglass::host {

class PileShadow {
 public:
  // Throws a Failure with the library's own sentence. `sky_texels`: a side of the texture of the room's light, 0 for
  // none.
  PileShadow(const PileShadowTrack& track, sandglass_isa isa, uint32_t sky_texels = 0);

  void set_light(Vec3 towards);
  void set_cells(std::span<const float, SANDGLASS_LIGHT_CELLS> cells);
  sandglass_pile_shadow* handle() const { return shadow_; }
  uint64_t bytes() const { return bytes_; }

  // A copy of the current texture. With `on_sand` it is the shadow on the sand itself, else that on the floor.
  FloorShadow drawn(bool on_sand) const;
  // The same of the room's light.
  FloorShadow drawn_sky(bool on_sand) const;

 private:
  Block block_;
  uint64_t bytes_ = 0;
  sandglass_pile_shadow* shadow_ = nullptr;
};

}  // namespace sandglass::host
