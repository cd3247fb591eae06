// The sphere caster with Embree: it uses Embree 3's sphere point geometry.
#include <cmath>
#include <vector>

#include "models/tracing/embree_scene.h"
#include "models/tracing/sphere_caster.h"

namespace sandglass::host {

struct SphereCaster::State {
  std::vector<uint32_t> source;  // index of each kept sphere
  EmbreeScene scene;
};

const char* SphereCaster::engine() { return "embree"; }

SphereCaster::SphereCaster(std::span<const float> centres, float radius, std::span<const float> sizes) {
  std::vector<uint32_t> source;
  std::vector<float> spheres;
  for (uint32_t i = 0; i < centres.size() / 3; ++i) {
    const float* c = centres.data() + size_t{3} * i;
    if (!std::isfinite(c[0]) || !std::isfinite(c[1]) || !std::isfinite(c[2])) continue;
    source.push_back(i);
    spheres.insert(spheres.end(), {c[0], c[1], c[2], sizes.empty() ? radius : radius * sizes[i]});
  }
  state_ = std::make_unique<State>(State{std::move(source), EmbreeScene::spheres(spheres)});
}

SphereCaster::~SphereCaster() = default;

bool SphereCaster::closest(Vec3 origin, Vec3 direction, SphereHit* hit) const {
  const EmbreeHit found = state_->scene.closest(origin, direction, hit->distance);
  if (!found.found) return false;
  *hit = {static_cast<double>(found.distance), state_->source[found.primitive]};
  return true;
}

bool SphereCaster::occluded(Vec3 origin, Vec3 direction, double limit) const {
  return state_->scene.occluded(origin, direction, limit);
}

}  // namespace sandglass::host
