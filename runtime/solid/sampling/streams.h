// The independent sequences of random numbers that the samplers draw from one seed.
#pragma once

#include "runtime/math/random.h"

namespace sandglass {

constexpr uint64_t k_stream_candidates = 1, k_stream_growth = 2, k_stream_probes = 3;

}  // namespace sandglass
