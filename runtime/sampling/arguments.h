// What every sampling function refuses, each with its own sentence. After these checks the algorithms run blind.
#pragma once

#include "runtime/core/finite.h"
#include "runtime/core/refuse.h"
#include "sandglass/sampling.h"

namespace sandglass {

// With these limits every index of the algorithms fits 32 bits, and every cell's key 63.
constexpr uint32_t k_triangle_limit = 1u << 27;
constexpr uint32_t k_point_limit = 1u << 30;
constexpr double k_axis_cell_limit = 1 << 20;

// Each returns SANDGLASS_OK, or refuses.
sandglass_status check_mesh(const sandglass_mesh* mesh, const char** reason);
sandglass_status check_box(const float bounds_min[3], const float bounds_max[3], const char** reason);
sandglass_status check_distance(float distance, const char** reason);
// *resolved: the options, or the defaults where `options` is NULL.
sandglass_status check_options(const sandglass_sample_options* options, sandglass_sample_options* resolved,
                               const char** reason);

}  // namespace sandglass
