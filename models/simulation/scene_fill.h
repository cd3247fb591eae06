// Fills the bodies of a scene with sand: particles on a hexagonal lattice, grains by Poisson disk or on a jittered
// grid, both through the library's own samplers. The same bits on every machine: only + - * / and sqrt on doubles.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "models/simulation/scene_file.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct BodyMesh {
  sandglass_mesh mesh = {};
  sandglass_inside_rule rule = SANDGLASS_INSIDE_PARITY;
};

// What the shapes "trefoil" and "mesh" of a scene stand for.
struct BodyMeshes {
  std::optional<BodyMesh> trefoil, argument;
};

struct RigidSample {
  std::vector<float> positions;  // 3 floats a particle
  double density = 1.0;          // over that of sand
  Vec3 velocity, spin;
};

struct Material {
  std::vector<RigidSample> rigid;
  std::vector<float> particle_positions, particle_velocities, grain_positions, grain_velocities;  // 3 floats an item
  uint32_t particles() const { return static_cast<uint32_t>(particle_positions.size() / 3); }
  uint32_t rigid_particles() const {
    size_t floats = 0;
    for (const RigidSample& body : rigid) floats += body.positions.size();
    return static_cast<uint32_t>(floats / 3);
  }
  uint32_t grains() const { return static_cast<uint32_t>(grain_positions.size() / 3); }
};

// Also sets scene->particle_radius where it follows from a body. A Failure names the body that cannot be filled as
// asked.
Material fill_scene(SceneFile* scene, const BodyMeshes& meshes);

}  // namespace sandglass::host
