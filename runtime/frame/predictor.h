// What a work unit will cost, from what units of its kind cost lately (predictor.cpp). Costs are integers and saturate,
// so the same clock gives the same predictions everywhere, and no reading can overflow anything.
#pragma once

#include "runtime/frame/governor.h"

namespace sandglass {

constexpr uint64_t k_time_max = ~static_cast<uint64_t>(0);

inline uint64_t add(uint64_t a, uint64_t b) { return a > k_time_max - b ? k_time_max : a + b; }

inline uint64_t multiply(uint64_t a, uint64_t b) { return b != 0 && a > k_time_max / b ? k_time_max : a * b; }

// What is kept free for something that is estimated to cost `ns`.
uint64_t with_margin(const PredictorPolicy& policy, const Spread& spread, uint64_t ns);

// Learns from something that cost `cost` and was estimated at `estimate`, in the same unit.
void spread_observe(const PredictorPolicy& policy, Spread* spread, uint64_t cost, uint64_t estimate);

// Learns from a unit that took `ns`.
void predictor_observe(Governor* governor, const WorkUnit& unit, uint64_t ns);

}  // namespace sandglass
