// The workload on which shadows are counted: one texture of a baked file, adaptive as in an app, from the new light to
// the last unit, and its first ambient texture. Prints for how many texels the network was evaluated.
//   count_shadow FILE [ISA]
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  std::FILE* file = argument_count > 1 ? std::fopen(arguments[1], "rb") : nullptr;
  if (file == nullptr) return wrong("count_shadow FILE [ISA]: FILE must be a baked shadow");
  std::vector<uint64_t> asset(1u << 17);  // aligned to 8 bytes; a megabyte
  sandglass_shadow_desc desc = sandglass::shadow_desc();
  desc.isa = argument_count > 2 ? std::atoi(arguments[2]) : SANDGLASS_ISA_AUTOMATIC;
  desc.asset = asset.data();
  desc.asset_bytes = std::fread(asset.data(), 1, asset.size() * sizeof(uint64_t), file);
  std::fclose(file);

  sandglass::Shadow shadow;
  sandglass_shadow_info info = {};
  sandglass::Status status = shadow.create(desc);
  if (status) status = shadow.set_light({0.3f, 1.0f, 0.2f});
  if (status) status = sandglass::inspect_shadow(desc.asset, desc.asset_bytes, &info);
  if (!status) return wrong(status.reason);

  counting_begins();
  while (sandglass_shadow_units_left(shadow.get()) != 0) shadow.run(64);
  counting_ends();

  const sandglass_texture texture = shadow.texture();
  const uint32_t evaluated = shadow.evaluated();
  const uint64_t macs = evaluated * info.macs_per_texel;
  std::printf("isa %s\nambient_texels %u\ntexels %u\nthousand_macs %llu\ntextures 1\nhash 0x%016llx\n",
              sandglass_isa_name(sandglass_shadow_isa(shadow.get())), info.ambient_texels * info.ambient_texels,
              evaluated, static_cast<unsigned long long>(macs / 1000), static_cast<unsigned long long>(shadow.hash()));
  return texture.valid == 1 ? 0 : 1;
}
