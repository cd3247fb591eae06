// The state as one number: the sum over all particles and grains of a hash of each. A sum, because their order in
// memory is not part of the state.
#include "runtime/math/hash.h"

#include "runtime/scene/scene.h"

namespace sandglass {
namespace {

// The kinds of item.
enum : uint32_t { k_hashed_particle, k_hashed_grain };

uint64_t item_hash(uint32_t kind, uint32_t number, const float position[3], const float velocity[3]) {
  uint64_t hash = hash_bytes(&kind, sizeof kind);
  hash = hash_bytes(&number, sizeof number, hash);
  hash = hash_bytes(position, 3 * sizeof(float), hash);
  return hash_bytes(velocity, 3 * sizeof(float), hash);
}

}  // namespace
}  // namespace sandglass

using namespace sandglass;

uint64_t sandglass_scene_hash(const sandglass_scene* scene) {
  if (scene == nullptr) return 0;
  const Granular& g = scene->granular;
  uint64_t hash = 0;
  for (uint32_t i = 0; i < g.particles.count; ++i) {
    const Particle& p = g.particles.records[0][i];
    hash += item_hash(k_hashed_particle, p.identity & ~k_departed, p.position, p.velocity);
  }
  for (uint32_t i = 0; i < g.grains.count; ++i) {
    const Grain& grain = g.grains.records[i];
    hash += item_hash(k_hashed_grain, grain.number, grain.position, grain.velocity);
  }
  return hash;
}
