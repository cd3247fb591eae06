// The sand kit's shaders (models/kit), compiled as C++ for pictures that no GPU draws.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "models/drawing/sand_shape.h"
#include "models/geometry/camera.h"

namespace sandglass::host {

// The light where sand is drawn, as the kit asks for it (light.glsl).
struct SandLight {
  Vec3 to_light, sun;                              // sun: irradiance over pi of what faces the main light
  std::function<Vec3(Vec3)> around, around_below;  // of a normal: the room's light, and the part of it from the floor
  // What the sand itself and objects leave of the main light at a place, and what all leave of the room's.
  std::function<double(Vec3)> pile_passed, object_passed, under_sky;
  double wet = 0.0;
};

// What a control of `verify look` changes, and its picture without the kit.
struct KitChange {
  double sharper = 0.0;  // levels of the block
  float coarser = 1.0f;  // the block's side
  bool plain = false;    // the surface is that of plain.frag, lit by Lambert's law
};

class KitShading {
 public:
  KitShading(const SandLight& light, const CameraFrame& camera, const SandShape& shape, double pixels,
             const KitChange& change = {});
  ~KitShading();
  KitShading(const KitShading& other);
  KitShading& operator=(const KitShading&) = delete;

  // Where a triangle is seen: between its corners by `share`, which changes by `right` and `down` from pixel to pixel.
  // Radiance; none where the foot leaves out a grain.
  struct Fragment {
    const sandglass_skin_vertex* corners[3];
    Vec3 place, right, down;
    double share[3];
  };
  std::optional<Vec3> surface(const Fragment& fragment);

  // A grain of a loose particle, as a square about its middle: its sides by half, along and across. Places in the picture
  // are pixels to the right and below of its middle.
  struct Grain {
    double x = 0.0, y = 0.0, depth = 0.0;
    double right[2] = {}, over[2] = {};
    double pixels = 0.0;  // of a ball, wide
    Vec3 colour;
  };
  // None where that grain is not seen.
  std::optional<Grain> grain(const sandglass_skin_loose& particle, bool flies, uint32_t which);
  // How many grains of a particle may be there, at that distance from the eye.
  uint32_t grains(bool flies, double away) const;
  // What of a grain's colour is seen at a place of its square, from -1 to 1 along and across; none beyond it.
  std::optional<Vec3> grain_at(const Grain& grain, double along, double across);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
