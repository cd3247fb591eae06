// What every sampling function refuses, each with its own sentence. After these checks the algorithms run blind.
#pragma once

#include "runtime/frame/refuse.h"
#include "runtime/math/finite.h"
#include "sandglass/sampling.h"

namespace sandglass {

// With these limits every index of the algorithms fits 32 bits, and every cell's key 63.
constexpr uint32_t k_triangle_limit = 1u << 27;
constexpr uint32_t k_point_limit = 1u << 30;
constexpr double k_axis_cell_limit = 1 << 20;

// Each returns SANDGLASS_OK, or refuses.
sandglass_status check_mesh(const sandglass_mesh* mesh, const char** reason);
// The box and the inside test of a volume.
sandglass_status check_volume(const sandglass_sample_desc& desc, const char** reason);

}  // namespace sandglass
