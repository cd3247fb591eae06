// A panorama as a light that rays sample, brighter pixels more often.
#pragma once

#include <vector>

#include "models/rooms/excerpt.h"
#include "models/rooms/panorama.h"

namespace sandglass::host {

class ProbeLight {
 public:
  // The map stays where it is. `rotation` turns its frame into the scene's.
  ProbeLight(const RadianceMap& map, const ViewRotation& rotation);

  struct Sample {
    Vec3 direction;  // in the frame of the scene
    Vec3 weight;     // radiance divided by the density of samples
  };
  // `a` and `b` are uniform in 0..1.
  Sample sample(double a, double b) const;

 private:
  const RadianceMap* map_;
  ViewRotation rotation_;
  std::vector<double> cumulative_;  // sums over pixels of luminance times solid angle
};

}  // namespace sandglass::host
