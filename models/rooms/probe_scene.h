// The scene of the dissertation's evaluation: a grey, diffuse object on a plane, lit by an environment and path traced.
// Light is linear, so the picture under any estimated light is a sum of two: one under the directional light and one
// under the ambient light, each of strength 1.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama.h"

namespace sandglass::host {

constexpr double k_light_half_angle_deg = 10.0;  // half angle of the soft directional light

// Light from infinity, in the frame of the scene (y up).
class ProbeLight {
 public:
  // A warped panorama, in the frame that `rotation` turns into the scene's.
  static ProbeLight environment(const RadianceMap& map, const ViewRotation& rotation);
  // A cap of 20 degrees that gives a facing surface the irradiance pi.
  static ProbeLight directional(Vec3 towards);
  static ProbeLight ambient();  // radiance 1 from everywhere

  struct Sample {
    Vec3 direction;
    Vec3 weight;  // radiance divided by the density of samples
  };
  Sample sample(Vec3 normal, double a, double b) const;

 private:
  enum class Kind { environment, directional, ambient } kind_ = Kind::ambient;
  Vec3 towards_;
  const RadianceMap* map_ = nullptr;
  ViewRotation rotation_{{0.0, 0.0}};
  std::vector<double> cumulative_;  // sums over pixels of luminance times solid angle
};

class ProbeScene {
 public:
  // The object is scaled to height 1 and put on the plane y = 0. Throws a Failure without Embree.
  explicit ProbeScene(const Mesh& object);
  ~ProbeScene();
  ProbeScene(const ProbeScene&) = delete;
  ProbeScene& operator=(const ProbeScene&) = delete;

  // The picture from above, from the azimuth of `view`. Equal arguments give equal bits. Any number of threads may call
  // it.
  RadianceMap render(const ProbeLight& light, View view, int samples) const;

  static constexpr int k_width = 96, k_height = 72;
  static constexpr double k_reflectance = 0.7;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
