// The workload on which the room's light on the sand is counted: textures of 64 x 64 texels of a pile of 24,000 grains,
// on the floor and on the sand, under an even sky, an uneven one and one bright cell. Each is counted from the new
// cells to the last unit, with its hash.
//   count_sky [ISA]
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sandglass/pile_shadow.h"
#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  constexpr uint32_t k_grains = 24000, k_skies = 3;
  constexpr float k_radius = 0.0035f, k_foot = 0.25f, k_height = 0.08f;
  sandglass_pile_shadow_desc desc;
  sandglass_pile_shadow_desc_default(&desc);
  desc.sky_texels = 64;
  desc.isa = argument_count > 1 ? std::atoi(arguments[1]) : SANDGLASS_ISA_AUTOMATIC;
  // A cone that is filled evenly: x and z lie over its foot, y below its surface.
  std::vector<float> grains;
  CountingRandom unit;
  while (grains.size() < 3 * k_grains) {
    const float x = k_foot * (2 * unit() - 1), z = k_foot * (2 * unit() - 1), y = k_height * unit();
    const float left = 1 - y / k_height;
    if (x * x + z * z < k_foot * k_foot * left * left) grains.insert(grains.end(), {x, y + k_radius, z});
  }
  const char* reason = nullptr;
  uint64_t bytes = 0;
  sandglass_pile_shadow* shadow = nullptr;
  if (sandglass_pile_shadow_bytes(&desc, &bytes, &reason) != SANDGLASS_OK)
    return std::fprintf(stderr, "%s\n", reason), 2;
  const sandglass::cpp::Block block = sandglass::cpp::allocate_block(bytes);
  if (sandglass_pile_shadow_create(&desc, block.get(), bytes, &shadow, &reason) != SANDGLASS_OK)
    return std::fprintf(stderr, "%s\n", reason), 2;
  float cells[k_skies][SANDGLASS_LIGHT_CELLS] = {};
  for (uint32_t i = 0; i < SANDGLASS_LIGHT_CELLS; ++i)
    cells[0][i] = 1.0f / SANDGLASS_LIGHT_CELLS, cells[1][i] = unit() / SANDGLASS_LIGHT_CELLS;
  cells[2][5] = 0.5f;
  uint64_t hash = 0;
  counting_begins();
  for (const float(&sky)[SANDGLASS_LIGHT_CELLS] : cells) {
    if (sandglass_pile_shadow_set_cells(shadow, sky, &reason) != SANDGLASS_OK) return 2;
    while (sandglass_pile_shadow_run(shadow, grains.data(), k_grains, k_radius, 64) != 0) continue;
    hash = hash * 31 + sandglass_pile_shadow_hash(shadow);
  }
  counting_ends();
  std::printf("isa %s\ntexels %u\ngrains_put %u\ntextures %u\nhash 0x%016llx\n", sandglass_isa_name(desc.isa),
              2 * k_skies * desc.sky_texels * desc.sky_texels, k_skies * k_grains, k_skies,
              static_cast<unsigned long long>(hash));
  return 0;
}
