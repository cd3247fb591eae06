// The workload on which the sand's own shadow is counted: textures of 128 x 128 texels of a pile of 24,000 grains, on
// the floor and on the sand, with the light 20, 45 and 65 degrees from the zenith. Each is counted from the new light
// to the last unit, with its hash.
//   count_pile [ISA]
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  constexpr uint32_t k_grains = 24000;
  constexpr float k_radius = 0.0035f, k_foot = 0.25f, k_height = 0.08f;
  sandglass_pile_shadow_desc desc = sandglass::pile_shadow_desc();
  desc.isa = argument_count > 1 ? std::atoi(arguments[1]) : SANDGLASS_ISA_AUTOMATIC;
  // A cone that is filled evenly: x and z lie over its foot, y below its surface.
  std::vector<float> grains;
  CountingRandom unit;
  while (grains.size() < 3 * k_grains) {
    const float x = k_foot * (2 * unit() - 1), z = k_foot * (2 * unit() - 1), y = k_height * unit();
    const float left = 1 - y / k_height;
    if (x * x + z * z < k_foot * k_foot * left * left) grains.insert(grains.end(), {x, y + k_radius, z});
  }
  sandglass::PileShadow shadow;
  const sandglass::Status made = shadow.create(desc);
  if (!made) return std::fprintf(stderr, "%s\n", made.reason), 2;
  constexpr std::array<float, 3> k_lights[] = {{0.342f, 0.940f, 0}, {0.707f, 0.707f, 0}, {0.906f, 0.423f, 0}};
  constexpr uint32_t lights = std::size(k_lights);
  uint64_t hash = 0;
  counting_begins();
  for (const std::array<float, 3>& light : k_lights) {
    if (!shadow.set_light(light)) return 2;
    while (shadow.run(grains, k_radius, 64) != 0) continue;
    hash = hash * 31 + shadow.hash();
  }
  counting_ends();
  std::printf("isa %s\ntexels %u\ngrains_put %u\ntextures %u\nhash 0x%016llx\n", sandglass_isa_name(desc.isa),
              2 * lights * desc.texels * desc.texels, lights * k_grains, lights, static_cast<unsigned long long>(hash));
  return 0;
}
