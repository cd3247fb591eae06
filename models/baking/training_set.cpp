// See training_set.h.
#include "models/baking/training_set.h"

#include <algorithm>
#include <cmath>

#include "models/work/random.h"

namespace sandglass::host {

namespace {
constexpr uint16_t k_dark = 655, k_lit = 65535 - 655;  // 1 % away from dark and from lit
}

ShadowRectangle LightGeometry::rectangle(const Direction& light) const {
  return shadow_rectangle(object.box, plane, light.data(), std::sin(half_angle), std::tan(polar_max + half_angle));
}

TrainingSet::Texel TrainingSet::texel(uint64_t index) const {
  const uint32_t side = cells();
  const uint64_t pick = random_mix(index) % (stride * stride);
  return {static_cast<uint32_t>(index / side / side), static_cast<uint32_t>(index % side * stride + pick % stride),
          static_cast<uint32_t>(index / side % side * stride + pick / stride)};
}

// Fills `penumbra` and `in_penumbra`.
static void find_penumbra(TrainingSet* set) {
  set->penumbra.clear();
  set->in_penumbra.assign(set->values.size(), false);
  const uint32_t side = set->cells();
  for (size_t light = 0; light < set->lights.size(); ++light) {
    const uint16_t* t = set->values.data() + light * side * side;
    const auto class_of = [&](uint32_t u, uint32_t v) {
      const uint16_t nu = t[size_t{v} * side + u];
      return nu <= k_dark ? 0 : nu >= k_lit ? 2 : 1;
    };
    for (uint32_t v = 0; v < side; ++v)
      for (uint32_t u = 0; u < side; ++u) {
        const int own = class_of(u, v);
        const bool plain = own != 1 && class_of(u > 0 ? u - 1 : u, v) == own &&
                           class_of(std::min(u + 1, side - 1), v) == own && class_of(u, v > 0 ? v - 1 : v) == own &&
                           class_of(u, std::min(v + 1, side - 1)) == own;
        if (plain) continue;
        const size_t index = (light * side + v) * side + u;
        set->penumbra.push_back(static_cast<uint32_t>(index));
        set->in_penumbra[index] = true;
      }
  }
}

bool trace_training_set(const LightGeometry& geometry, const ShadowCaster& caster, ThreadPool& pool,
                        const std::function<bool(uint32_t)>& go_on, TrainingSet* set) {
  const uint32_t count = set->cells() * set->cells(), lights = static_cast<uint32_t>(set->lights.size());
  constexpr uint32_t k_group = 8;   // lights at a time; threads wait for each other once per group
  constexpr uint32_t k_part = 512;  // texels that a thread takes at a time
  const uint32_t parts = (count + k_part - 1) / k_part;
  std::vector<float> values(size_t{k_group} * count);
  for (uint32_t done = 0; done < lights;) {
    const uint32_t group = std::min(k_group, lights - done);
    pool.run(group * parts, [&](uint32_t task) {
      const uint32_t light = done + task / parts, begin = task % parts * k_part, end = std::min(count, begin + k_part);
      std::vector<uint32_t> uv;
      for (uint32_t i = begin; i < end; ++i) {
        const TrainingSet::Texel texel = set->texel(uint64_t{light} * count + i);
        uv.insert(uv.end(), {texel.u, texel.v});
      }
      const Direction& direction = set->lights[light];
      caster.texels(geometry.rectangle(direction), direction, light, set->size, set->size, uv.data(), end - begin,
                    &values[size_t{task / parts} * count + begin]);
    });
    for (size_t i = 0; i < size_t{group} * count; ++i)
      set->values.push_back(static_cast<uint16_t>(std::lround(values[i] * 65535.0f)));
    done += group;
    if (!go_on(done) && done < lights) return false;
  }
  find_penumbra(set);
  return true;
}

}  // namespace sandglass::host
