// See pile_shadow.h.
#include "models/simulation/pile_shadow.h"

#include "models/files/failure.h"

namespace sandglass::host {

// `reason` is a reference because the call that sets it is an argument too, and C++ may evaluate arguments in any
// order.
static void require(sandglass_status status, const char* const& reason) {
  if (status != SANDGLASS_OK)
    throw cannot("make", "pile_shadow", reason != nullptr ? reason : sandglass_status_name(status));
}

PileShadow::PileShadow(const PileShadowTrack& track, sandglass_isa isa, uint32_t sky_texels) {
  sandglass_pile_shadow_desc desc;
  sandglass_pile_shadow_desc_default(&desc);
  desc.isa = isa;
  for (size_t axis = 0; axis < 2; ++axis) {
    desc.low[axis] = static_cast<float>(track.low[axis]);
    desc.high[axis] = static_cast<float>(track.high[axis]);
  }
  desc.texels = track.texels, desc.sky_texels = sky_texels;
  const char* reason = nullptr;
  require(sandglass_pile_shadow_bytes(&desc, &bytes_, &reason), reason);
  block_ = new_block(bytes_, "the sand's shadow", "give its \"pile_shadow\" fewer texels");
  require(sandglass_pile_shadow_create(&desc, block_.get(), bytes_, &shadow_, &reason), reason);
}

void PileShadow::set_light(Vec3 towards) {
  float direction[3];
  to_floats(towards, direction);
  const char* reason = nullptr;
  require(sandglass_pile_shadow_set_light(shadow_, direction, &reason), reason);
}

void PileShadow::set_cells(std::span<const float, SANDGLASS_LIGHT_CELLS> cells) {
  const char* reason = nullptr;
  require(sandglass_pile_shadow_set_cells(shadow_, cells.data(), &reason), reason);
}

FloorShadow PileShadow::drawn(bool on_sand) const {
  sandglass_pile_shadow_texture texture = {};
  texture.struct_size = sizeof texture;
  sandglass_pile_shadow_get_texture(shadow_, &texture);
  FloorShadow drawn;
  drawn.collider = ~0u;
  drawn.texels = texture.texels;
  const uint8_t* bytes = on_sand ? texture.on_sand : texture.coverage;
  drawn.coverage.assign(bytes, bytes + drawn.texels * drawn.texels);
  drawn.opacity = texture.valid != 0 ? static_cast<double>(texture.opacity) : 0.0;
  for (size_t axis = 0; axis < 2; ++axis) {
    drawn.low[axis] = static_cast<double>(texture.low[axis]);
    drawn.high[axis] = static_cast<double>(texture.high[axis]);
  }
  return drawn;
}

FloorShadow PileShadow::drawn_sky(bool on_sand) const {
  sandglass_pile_shadow_sky sky = {};
  sky.struct_size = sizeof sky;
  sandglass_pile_shadow_get_sky(shadow_, &sky);
  FloorShadow drawn;
  drawn.collider = ~0u;
  drawn.texels = sky.texels;
  const uint8_t* bytes = on_sand ? sky.on_sand : sky.floor;
  for (uint32_t i = 0; i < sky.texels * sky.texels; ++i) drawn.coverage.push_back(static_cast<uint8_t>(255 - bytes[i]));
  for (size_t axis = 0; axis < 2; ++axis) {
    drawn.low[axis] = static_cast<double>(sky.low[axis]);
    drawn.high[axis] = static_cast<double>(sky.high[axis]);
  }
  return drawn;
}

}  // namespace sandglass::host
