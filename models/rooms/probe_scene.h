// The experiment of the source's evaluation: an object on a plane, lit by an environment, path traced (diffuse, grey).
// Light is linear, so the parametric light of any colour is a sum of two pictures: one of the directional light and one
// of the ambient light, each of strength 1.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "models/mesh/mesh.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama.h"

namespace sandglass::host {

constexpr double k_light_half_angle_deg = 10.0;  // of the soft directional light

// Light from infinity, in the frame of the scene (y up).
class ProbeLight {
 public:
  // A warped panorama, in the frame that `rotation` takes to the scene's.
  static ProbeLight environment(const RadianceMap& map, const ViewRotation& rotation);
  // A cap of 20 degrees that gives a facing surface the irradiance pi.
  static ProbeLight directional(Vec3 towards);
  static ProbeLight ambient();  // radiance 1 from everywhere

  struct Sample {
    Vec3 direction;
    Vec3 weight;  // radiance over density
  };
  Sample sample(Vec3 normal, double a, double b) const;

 private:
  enum class Kind { environment, directional, ambient } kind_ = Kind::ambient;
  Vec3 towards_;
  const RadianceMap* map_ = nullptr;
  ViewRotation rotation_{{0.0, 0.0}};
  std::vector<double> cumulative_;  // over pixels: luminance times solid angle
};

struct ProbeImage {
  RadianceMap radiance;
  std::vector<float> lit;  // on the plane: irradiance over that without the object; -1 on the object
};

class ProbeScene {
 public:
  // The object is scaled to height 1 and put on the plane y = 0. Needs Embree, else a Failure.
  explicit ProbeScene(const Mesh& object);
  ~ProbeScene();
  ProbeScene(const ProbeScene&) = delete;
  ProbeScene& operator=(const ProbeScene&) = delete;

  // Seen from the azimuth of `view`, from above. Equal arguments give equal bits; any number of threads may call.
  ProbeImage render(const ProbeLight& light, View view, int samples) const;

  static constexpr int k_width = 96, k_height = 72;
  static constexpr double k_reflectance = 0.7;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
