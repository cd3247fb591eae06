// Fills the bodies of a scene with sand: particles on a hexagonal lattice, grains by Poisson disk or on a jittered
// grid. Lattices in a shape and Poisson disks come from the library's own samplers. The result has the same bits on
// every machine: only + - * / and sqrt are used on doubles.
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

// The meshes for the shapes "trefoil" and "mesh" of a scene.
struct BodyMeshes {
  std::optional<BodyMesh> trefoil, argument;
};

struct RigidSample {
  std::vector<float> positions;  // 3 floats per particle
  double density = 1.0;          // relative to sand
  Vec3 velocity, spin;
};

struct Material {
  std::vector<RigidSample> rigid;
  std::vector<float> particle_positions, particle_velocities, grain_positions, grain_velocities;  // 3 floats per item
  uint32_t particles() const { return static_cast<uint32_t>(particle_positions.size() / 3); }
  uint32_t rigid_particles() const {
    size_t floats = 0;
    for (const RigidSample& body : rigid) floats += body.positions.size();
    return static_cast<uint32_t>(floats / 3);
  }
  uint32_t grains() const { return static_cast<uint32_t>(grain_positions.size() / 3); }
};

// Fills all bodies. Also sets scene->particle_radius when it follows from a body. A Failure names the body that cannot
// be filled as the file asks.
Material fill_scene(SceneFile* scene, const BodyMeshes& meshes);

}  // namespace sandglass::host
