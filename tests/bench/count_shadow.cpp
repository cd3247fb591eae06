// The workload on which shadows are counted: one texture of a baked file, adaptive as in an app, from the new light to
// the last unit, and its first ambient texture. Prints for how many texels the network was evaluated.
//   count_shadow FILE [ISA]
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "sandglass/shadow.h"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  std::FILE* file = argument_count > 1 ? std::fopen(arguments[1], "rb") : nullptr;
  if (file == nullptr) return std::fprintf(stderr, "count_shadow FILE [ISA]: FILE must be a baked shadow\n"), 2;
  std::vector<uint64_t> asset(1u << 17);  // aligned to 8 bytes; a megabyte
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.isa = argument_count > 2 ? std::atoi(arguments[2]) : SANDGLASS_ISA_AUTOMATIC;
  desc.asset = asset.data();
  desc.asset_bytes = std::fread(asset.data(), 1, asset.size() * sizeof(uint64_t), file);
  std::fclose(file);

  const char* reason = nullptr;
  uint64_t bytes = 0;
  sandglass_shadow* shadow = nullptr;
  if (sandglass_shadow_bytes(&desc, &bytes, &reason) != SANDGLASS_OK) return std::fprintf(stderr, "%s\n", reason), 2;
  const sandglass::cpp::Block block = sandglass::cpp::allocate_block(bytes);
  const float light[3] = {0.3f, 1.0f, 0.2f};
  if (sandglass_shadow_create(&desc, block.get(), bytes, &shadow, &reason) != SANDGLASS_OK ||
      sandglass_shadow_set_light(shadow, 0, light, 1.0f, &reason) != SANDGLASS_OK)
    return std::fprintf(stderr, "%s\n", reason), 2;
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  if (sandglass_shadow_inspect(desc.asset, desc.asset_bytes, &info, &reason) != SANDGLASS_OK) return 2;

  counting_begins();
  while (sandglass_shadow_units_left(shadow) != 0) sandglass_shadow_run(&shadow, 1, 64);
  counting_ends();

  sandglass_shadow_texture texture = {};
  texture.struct_size = sizeof texture;
  sandglass_shadow_get_texture(shadow, 0, &texture);
  const uint64_t macs = texture.evaluated * info.macs_per_texel;
  std::printf("isa %s\nambient_texels %u\ntexels %u\nthousand_macs %llu\ntextures 1\nhash 0x%016llx\n",
              sandglass_isa_name(sandglass_shadow_isa(shadow)), info.ambient_texels * info.ambient_texels,
              texture.evaluated, static_cast<unsigned long long>(macs / 1000),
              static_cast<unsigned long long>(sandglass_shadow_hash(shadow)));
  return texture.valid == 1 ? 0 : 1;
}
