// The baked shadows of a scene's standing objects. They are made from their files, turned with the light, handed to the
// frame, and copied for the pictures.
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
  // Loads the shadows of all colliders that have one. A Failure names what cannot be read.
  StandingShadows(const SceneFile& scene, sandglass_isa isa);

  // Turns the light of the frame into every object's frame of reference. `towards` may have any length above 0.
  void set_light(const SceneFile& scene, uint32_t frame, Vec3 towards);
  std::span<sandglass_shadow* const> handles() const { return handles_; }
  uint64_t hash() const;  // 0 without shadows

  // Copies of the current textures. `colliders` are the scene's colliders at this moment.
  std::vector<FloorShadow> drawn(std::span<const sandglass_collider> colliders) const;

 private:
  struct Object {
    uint32_t collider;
    double size;  // height of the standing object, metres
    sandglass_shadow_info info;
    cpp::Shadow shadow;
  };
  std::vector<Object> objects_;
  std::vector<sandglass_shadow*> handles_;
};

// The path of a baked shadow, from a file's path or from the name of a shipped shadow.
std::string find_shadow(const std::string& name_or_path);

// What a baked shadow's file says about it. Throws a Failure that names the path.
sandglass_shadow_info inspect_shadow(const AlignedBytes& file, const std::string& path);

}  // namespace sandglass::host
