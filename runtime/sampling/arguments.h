// What every sampling function refuses, checked once, each refusal one sentence; after these checks the algorithms run
// blind.
#pragma once

#include "sandglass/sampling.h"

namespace sandglass {

// Limits that keep every index of the algorithms within 32 bits and every cell key within 63.
constexpr uint32_t k_triangle_limit = 1u << 27;
constexpr uint32_t k_point_limit = 1u << 30;
constexpr double k_axis_cell_limit = 1 << 20;

sandglass_status refuse(const char** reason, sandglass_status status, const char* sentence);
sandglass_status accept(const char** reason);

// Each returns SANDGLASS_OK, or refuses.
sandglass_status check_mesh(const sandglass_mesh* mesh, const char** reason);
sandglass_status check_box(const float bounds_min[3], const float bounds_max[3], const char** reason);
sandglass_status check_distance(float distance, const char** reason);
sandglass_status check_block(const void* block, uint64_t bytes, uint64_t need, const char** reason);
// Replaces NULL by the defaults.
sandglass_status check_options(const sandglass_sample_options* options, sandglass_sample_options* resolved,
                               const char** reason);

bool is_finite(double x);

}  // namespace sandglass
