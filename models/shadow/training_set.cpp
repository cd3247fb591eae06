#include "models/shadow/training_set.h"

#include <algorithm>
#include <cmath>

namespace sandglass::host {

namespace {
constexpr uint16_t k_dark = 655, k_lit = 65535 - 655;  // 1 % of transparency
}

ShadowRectangle LightGeometry::rectangle(const Direction& light) const {
  return shadow_rectangle(object.box, plane, light.data(), std::sin(half_angle), std::tan(polar_max + half_angle));
}

bool trace_training_set(const LightGeometry& geometry, const ShadowCaster& caster, ThreadPool& pool,
                        const std::function<bool(uint32_t)>& go_on, TrainingSet* set) {
  const size_t texels = size_t{set->size} * set->size;
  for (uint32_t done = static_cast<uint32_t>(set->texels.size() / texels); done < set->lights.size();) {
    const Direction& light = set->lights[done];
    const std::vector<float> texture = caster.texture(geometry.rectangle(light), light, done, set->size, pool);
    for (const float nu : texture) set->texels.push_back(static_cast<uint16_t>(std::lround(nu * 65535.0f)));
    if (!go_on(++done) && done < set->lights.size()) return false;
  }
  find_penumbra(set);
  return true;
}

void find_penumbra(TrainingSet* set) {
  set->penumbra.clear();
  const uint32_t size = set->size;
  for (size_t texture = 0; texture < set->lights.size(); ++texture) {
    const uint16_t* t = set->texels.data() + texture * size * size;
    const auto class_of = [&](uint32_t u, uint32_t v) {
      const uint16_t nu = t[size_t{v} * size + u];
      return nu <= k_dark ? 0 : nu >= k_lit ? 2 : 1;
    };
    for (uint32_t v = 0; v < size; ++v)
      for (uint32_t u = 0; u < size; ++u) {
        const int own = class_of(u, v);
        const bool plain = own != 1 && class_of(u > 0 ? u - 1 : u, v) == own &&
                           class_of(std::min(u + 1, size - 1), v) == own && class_of(u, v > 0 ? v - 1 : v) == own &&
                           class_of(u, std::min(v + 1, size - 1)) == own;
        if (!plain) set->penumbra.push_back(static_cast<uint32_t>((texture * size + v) * size + u));
      }
  }
}

}  // namespace sandglass::host
