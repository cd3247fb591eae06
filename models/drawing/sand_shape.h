// The surface of sand at one moment (skin.h of the library), as pictures need it: copied, from whatever particles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "models/geometry/vec3.h"
#include "sandglass/pile_shadow.h"
#include "sandglass/sandglass.h"
#include "sandglass/skin.h"

namespace sandglass::host {

struct SandShape {
  std::vector<sandglass_skin_vertex> vertices;
  std::vector<uint32_t> indices;  // the last one of a triangle tells its block
  std::vector<sandglass_skin_loose> loose;
  uint32_t flying = 0;  // the first ones
  float particle_radius = 0.01f;
  std::vector<sandglass_emitter> nozzles;  // that pour now
  double seconds = 0.02;                   // of a frame

  Vec3 position(uint32_t vertex) const { return from_floats(vertices[vertex].position); }
};

// Whether sand lies in a container, so that its skin must be closed.
bool behind_glass(std::span<const sandglass_collider> colliders);

// A copy of what the skin is now; none: sand without any.
SandShape shape_of(const sandglass_skin* skin, float particle_radius);

// Positions and velocities of particles, three floats each, and what they lie on.
struct LyingSand {
  std::span<const float> positions, velocities;  // no velocities: it rests
  std::span<const sandglass_collider> colliders;
  float particle_radius = 0.01f;
  float gravity[3] = {0, -9.81f, 0};
};

// Makes one shape after the other. Patches keep their grains from shape to shape while the particles keep their order.
class SandShaper {
 public:
  SandShaper();
  ~SandShaper();
  // `pile`, if not null, then has the shadow of this sand too.
  SandShape shape(const LyingSand& sand, sandglass_pile_shadow* pile = nullptr);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host
