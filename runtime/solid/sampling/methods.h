// The methods of sandglass_sample_points.
#pragma once

#include "sandglass/sampling.h"

namespace sandglass {

// What a method is asked for, and what it answers. Without `points` it only says what a run would need.
struct SampleCall {
  uint32_t capacity;  // points that there is room for
  void* scratch;
  uint64_t scratch_bytes;
  float* points;
  uint32_t enough;  // a capacity that always is
  uint64_t bytes;   // of working memory
  uint32_t count;   // points that were written
};

constexpr const char* k_beyond_capacity =
    "more points than capacity: see sandglass_sample_capacity, or enlarge distance";

// Each checks the fields that are its own; the others are checked.
sandglass_status sample_on_surface(const sandglass_sample_desc& desc, SampleCall* call, const char** reason);
sandglass_status sample_in_volume(const sandglass_sample_desc& desc, SampleCall* call, const char** reason);
sandglass_status sample_on_lattice(const sandglass_sample_desc& desc, SampleCall* call, const char** reason);

}  // namespace sandglass
