// See shadow_runner.h.
#include "models/baking/shadow_runner.h"

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
  if (const cpp::Status made = shadow_.create(desc); !made) throw cannot("read", name, made.reason);
}

sandglass_shadow_texture ShadowRunner::texture(const Direction& light) {
  const cpp::Status turned =
      shadow_.set_light({static_cast<float>(light[0]), static_cast<float>(light[1]), static_cast<float>(light[2])});
  if (!turned) throw cannot("turn", "light", turned.reason);
  while (shadow_.run() > 0) {
  }
  return shadow_.texture();
}

}  // namespace sandglass::host
