// The baked shadows of a scene's standing objects: made from their files, turned with the light, handed to the frame,
// and copied for the pictures.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "models/files/aligned_bytes.h"
#include "models/simulation/floor_shadow.h"
#include "models/simulation/scene_file.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

class StandingShadows {
 public:
  // Of the colliders that have one. A Failure names what cannot be read.
  StandingShadows(const SceneFile& scene, sandglass_isa isa);

  // The light of the frame, turned into every object's frame.
  void set_light(const SceneFile& scene, uint32_t frame, Vec3 towards);  // of any length above 0
  std::span<sandglass_shadow* const> handles() const { return handles_; }
  uint64_t hash() const;  // 0 without shadows

  // As they are now, `colliders` being the scene's at this moment.
  std::vector<FloorShadow> drawn(std::span<const sandglass_collider> colliders) const;

 private:
  struct Object {
    uint32_t collider;
    double size;  // of the standing object, metres
    sandglass_shadow_info info;
    cpp::Shadow shadow;
  };
  std::vector<Object> objects_;
  std::vector<sandglass_shadow*> handles_;
};

// The path of a baked shadow: the file itself, or a shipped one's name.
std::string find_shadow(const std::string& name_or_path);

// What a baked shadow says of itself, or a Failure that names its path.
sandglass_shadow_info inspect_shadow(const AlignedBytes& file, const std::string& path);

}  // namespace sandglass::host
