// See shadow_runner.h.
#include "models/baking/shadow_runner.h"

#include <algorithm>
#include <ctime>

#include "models/files/aligned_bytes.h"
#include "models/files/failure.h"

namespace sandglass::host {

ShadowRunner::ShadowRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa,
                           sandglass_shadow_mode mode) {
  const AlignedBytes aligned(file);
  sandglass_shadow_desc desc;
  sandglass_shadow_desc_default(&desc);
  desc.isa = isa;
  desc.asset = aligned.data();
  desc.asset_bytes = file.size();
  desc.mode = mode;
  desc.light_tolerance = 0;
  if (const cpp::Status made = shadow_.create(desc); !made) throw cannot("read", name, made.reason);
}

sandglass_texture ShadowRunner::texture(const Direction& light) {
  const cpp::Status turned =
      shadow_.set_light({static_cast<float>(light[0]), static_cast<float>(light[1]), static_cast<float>(light[2])});
  if (!turned) throw cannot("turn", "light", turned.reason);
  while (shadow_.run() > 0) {
  }
  return shadow_.texture();
}

std::vector<uint8_t> ShadowRunner::ambient(const std::array<double, SANDGLASS_LIGHT_CELLS>& cells) {
  std::array<float, SANDGLASS_LIGHT_CELLS> shares;
  for (size_t i = 0; i < shares.size(); ++i) shares[i] = static_cast<float>(cells[i]);
  if (const cpp::Status set = shadow_.set_cells(shares); !set) throw cannot("set", "cells", set.reason);
  while (shadow_.run() > 0) {
  }
  const sandglass_texture now = shadow_.ambient();
  return {now.bytes, now.bytes + size_t{now.side} * now.side};
}

double ShadowRunner::ambient_ms() {
  std::vector<double> times;
  for (uint32_t turn = 0; turn < 64; ++turn) {
    std::array<double, SANDGLASS_LIGHT_CELLS> cells = {};
    cells[turn] = 1;
    const std::clock_t from = std::clock();
    ambient(cells);
    times.push_back(1e3 * static_cast<double>(std::clock() - from) / CLOCKS_PER_SEC);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

}  // namespace sandglass::host
