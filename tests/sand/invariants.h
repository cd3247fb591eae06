// What must hold after every frame of any scene above a floor at y = 0: all numbers are finite, no sand is below the
// floor, nothing is faster than the CFL limit allows, nothing is lost or made, the budget's law and the ledger of time
// hold, and no byte outside the scene's block and the app's buffer is touched.
#pragma once

#include <string>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"

namespace sandglass::tests {

// A scene in a block of its own, with what a test knows about it. The floor is the last of its colliders.
struct WatchedScene {
  // Sand and bodies that the app has put into the scene. Emitters and sinks are in the reports.
  uint64_t particles_added = 0, grains_added = 0;
  // Seconds that the frames so far have asked for, as the library counts them.
  double asked = 0.0;
  // Numbers of particles from which those of bodies begin; bodies are added first, so they are below it.
  uint32_t in_bodies = 0;
  // A collider that only grains see comes after the floor, and may push grains below it.
  bool grains_have_floor = true;
  // A rigid body that another collider presses into the floor cannot obey both.
  bool bodies_have_floor = true;

  sandglass_scene_desc desc;
  Scene scene;
  test::GuardedBlock block{0}, drawn{0};
};

// m/s: the speed that sand of the app and of nozzles has at most.
constexpr double k_given_speed = 3.0;

class Invariants {
 public:
  explicit Invariants(const WatchedScene& scene) : s_(scene) {}

  // What is wrong after a frame; empty: nothing.
  std::string broken(const sandglass_frame_report& report);

 private:
  std::string particles(const sandglass_frame_report& report);
  bool alone(uint32_t particle, uint32_t count) const;
  std::string grains(const sandglass_frame_report& report);

  const WatchedScene& s_;
  float substep_before_ = 0.0f;  // of the last report
  std::vector<float> positions_, velocities_;
};

}  // namespace sandglass::tests
