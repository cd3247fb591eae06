// What the kit's block of grains stands for, to trace rays against: balls of 0.6 mm, of its minerals, packed at random in a
// layer below the surface of sand. Under them is ground of their mean colour. Needs Embree. Loose sand is left out.
#pragma once

#ifdef SANDGLASS_HAVE_EMBREE

#include <memory>
#include <optional>

#include "models/drawing/sand_shape.h"

namespace sandglass::host {

class PackedGrains {
 public:
  // The sand lies on y = 0 or above. Equal shapes give equal grains.
  explicit PackedGrains(const SandShape& shape);
  ~PackedGrains();

  struct Hit {
    double distance = 0.0;
    Vec3 normal, albedo;
  };
  std::optional<Hit> closest(Vec3 origin, Vec3 direction, double limit) const;
  bool occluded(Vec3 origin, Vec3 direction, double limit) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

#endif
