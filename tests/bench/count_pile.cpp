// The workloads on which the sand's own shadow and the room's light on the sand are counted: textures of a pile of
// 24,000 grains, on the floor and on the sand. The shadow is of 128 x 128 texels, with the light 20, 45 and 65 degrees
// from the zenith. The light has 64 x 64 texels, under an even sky, an uneven one and one bright cell. Each is counted
// from the new light to the last unit, with its hash.
//   count_pile shadow|sky [ISA]
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  const bool sky = argument_count > 1 && std::string(arguments[1]) == "sky";
  constexpr uint32_t k_grains = 24000, k_textures = 3;
  constexpr float k_radius = 0.0035f, k_foot = 0.25f, k_height = 0.08f;
  sandglass_pile_shadow_desc desc = sandglass::pile_shadow_desc();
  desc.sky_texels = sky ? 64 : 0;
  desc.isa = argument_count > 2 ? std::atoi(arguments[2]) : SANDGLASS_ISA_AUTOMATIC;
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
  if (!made) return wrong(made.reason);
  constexpr std::array<float, 3> k_lights[k_textures] = {{0.342f, 0.940f, 0}, {0.707f, 0.707f, 0}, {0.906f, 0.423f, 0}};
  std::array<float, SANDGLASS_LIGHT_CELLS> cells[k_textures] = {};
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i) {
    cells[0][i] = 1.0f / SANDGLASS_LIGHT_CELLS;
    cells[1][i] = unit() / SANDGLASS_LIGHT_CELLS;
  }
  cells[2][5] = 0.5f;
  uint64_t hash = 0;
  counting_begins();
  for (uint32_t i = 0; i < k_textures; ++i) {
    if (!(sky ? shadow.set_cells(cells[i]) : shadow.set_light(k_lights[i]))) return 2;
    while (shadow.run(grains, k_radius, 64) != 0) continue;
    hash = hash * 31 + shadow.hash();
  }
  counting_ends();
  const uint32_t side = sky ? desc.sky_texels : desc.texels;
  std::printf("isa %s\ntexels %u\ngrains_put %u\ntextures %u\nhash 0x%016llx\n", sandglass_isa_name(desc.isa),
              2 * k_textures * side * side, k_textures * k_grains, k_textures, static_cast<unsigned long long>(hash));
  return 0;
}
