// The shadows of a scene: those of its standing objects, baked or cast, and that of its sand. They are made from the scene
// file's description, turned with the light, handed to the frame, and copied for the pictures.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "models/files/aligned_bytes.h"
#include "models/mesh/mesh.h"
#include "models/simulation/floor_shadow.h"
#include "models/simulation/scene_file.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

class StandingShadows {
 public:
  // Loads the shadows of all colliders that have one, and the meshes of those that cast. A Failure names what cannot be
  // read.
  StandingShadows(const SceneFile& scene, sandglass_isa isa);

  // Turns the light of the frame into every object's frame of reference. `towards` may have any length above 0.
  void set_light(const SceneFile& scene, uint32_t frame, Vec3 towards);
  // Sets the light of the room at every object, in cells of the world's frame.
  void set_cells(const SceneFile& scene, uint32_t frame, const float (&cells)[SANDGLASS_LIGHT_CELLS]);
  std::span<sandglass_shadow* const> handles() const { return handles_; }
  std::span<sandglass_cast* const> casts() const { return cast_handles_; }
  // All work of both, at once.
  void complete() const;
  uint64_t hash() const;  // 0 without shadows

  // Copies of the current textures, into *shadows. `colliders` are the scene's colliders at this moment.
  void draw(std::span<const sandglass_collider> colliders, SceneShadows* shadows) const;

 private:
  void add_cast(const ColliderTrack& track, uint32_t collider, sandglass_isa isa);
  struct Object {
    uint32_t collider;
    double size;  // height of the standing object, metres
    sandglass_shadow_info info;
    cpp::Shadow shadow;
  };
  // An object without a bake.
  struct Casting {
    uint32_t collider;
    Mesh mesh;
    cpp::Cast cast;
  };
  std::vector<Object> objects_;
  std::vector<Casting> casting_;
  std::vector<sandglass_shadow*> handles_;
  std::vector<sandglass_cast*> cast_handles_;
};

class PileShadow {
 public:
  // Throws a Failure with the library's own sentence. `sky_texels`: a side of the texture of the room's light, 0 for
  // none.
  PileShadow(const PileShadowTrack& track, sandglass_isa isa, uint32_t sky_texels = 0);

  void set_light(Vec3 towards);
  void set_cells(const float (&cells)[SANDGLASS_LIGHT_CELLS]);
  sandglass_pile_shadow* handle() const { return shadow_.get(); }

  // Copies of all textures, into *shadows.
  void draw(SceneShadows* shadows) const;

 private:
  cpp::PileShadow shadow_;
};

// The path of a baked shadow, from a file's path or from the name of a shipped shadow.
std::string find_shadow(const std::string& name_or_path);

// What a baked shadow's file says about it. Throws a Failure that names the path.
sandglass_shadow_info inspect_shadow(const AlignedBytes& file, const std::string& path);

}  // namespace sandglass::host
