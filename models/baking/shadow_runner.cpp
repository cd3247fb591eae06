#include "models/baking/shadow_runner.h"

#include <new>

#include "models/files/aligned_bytes.h"
#include "models/files/failure.h"

namespace sandglass::host {

ShadowRunner::ShadowRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                           sandglass_shadow_mode mode, int32_t threshold) {
  const AlignedBytes aligned(file);
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.isa = isa, desc.asset = aligned.data(), desc.asset_bytes = file.size();
  desc.mode = mode, desc.light_tolerance = 0;
  if (threshold >= 0) desc.threshold = static_cast<uint32_t>(threshold);
  uint64_t bytes = 0;
  const char* reason = nullptr;
  if (sandglass_shadow_bytes(&desc, &bytes, &reason) != SANDGLASS_OK) throw cannot("read", name, reason);
  block_ = ::operator new (bytes, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT});
  if (sandglass_shadow_create(&desc, block_, bytes, &shadow_, &reason) != SANDGLASS_OK) {
    ::operator delete (block_, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT});
    throw cannot("read", name, reason);
  }
}

ShadowRunner::~ShadowRunner() { ::operator delete (block_, std::align_val_t{SANDGLASS_BLOCK_ALIGNMENT}); }

sandglass_shadow_texture ShadowRunner::texture(const Direction& light) {
  const float direction[3] = {static_cast<float>(light[0]), static_cast<float>(light[1]), static_cast<float>(light[2])};
  const char* reason = nullptr;
  if (sandglass_shadow_set_light(shadow_, 0, direction, 1, &reason) != SANDGLASS_OK)
    throw cannot("turn", "light", reason);
  while (sandglass_shadow_run(&shadow_, 1, 1u << 20) > 0) {
  }
  sandglass_shadow_texture texture = {};
  texture.struct_size = sizeof texture;
  sandglass_shadow_get_texture(shadow_, 0, &texture);
  return texture;
}

}  // namespace sandglass::host
