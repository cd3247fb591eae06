// The estimate of a kind is a high quantile of its 16 most recent costs an item. An outlier counts only for a few
// estimates; an estimate that nothing checks fades.
#include "runtime/frame/predictor.h"

namespace sandglass {
namespace {

constexpr uint64_t k_picoseconds_per_nanosecond = 1000;
constexpr uint32_t k_history = sizeof(Governor::Kind::recent) / sizeof(uint64_t);

// With fewer observations than this there is no "usual" to measure an outlier by.
constexpr uint32_t k_censor_from = 4;
// An estimate that no unit has checked for about a second is halved. Otherwise a kind that only a better level runs
// could keep that level away for ever.
constexpr uint32_t k_idle_frames_per_halving = 64;

// By how much an excess raises a spread: enough to follow a kind that becomes uneven within a few excesses.
constexpr uint32_t k_spread_step = k_spread_one / 16;
// An excess beyond three estimates is the machine's, not the kind's: a processor taken away, or throttled.
constexpr uint32_t k_foreseeable = 3;

// The largest recent cost after the largest `dropped` of 16 are left out; of fewer costs, proportionally fewer.
uint64_t quantile(const Governor::Kind& kind, uint32_t dropped) {
  const uint32_t leave_out = dropped * kind.count / k_history;
  uint64_t bound = k_time_max;
  uint32_t left_out = 0;
  for (;;) {
    uint64_t largest = 0;
    uint32_t equals = 0;
    for (uint32_t i = 0; i < kind.count; ++i) {
      const uint64_t cost = kind.recent[i];
      if (cost >= bound && bound != k_time_max) continue;
      if (cost > largest) {
        largest = cost;
        equals = 0;
      }
      equals += cost == largest;
    }
    left_out += equals;
    if (left_out > leave_out) return largest;
    bound = largest;
  }
}

}  // namespace

uint64_t with_margin(const PredictorPolicy& policy, const Spread& spread, uint64_t ns) {
  const uint32_t ratio = policy.exceeded_once_in == 0 ? k_spread_min : spread.ratio;
  return add(ns, multiply(ns, ratio - k_spread_one) / k_spread_one);
}

void spread_observe(const PredictorPolicy& policy, Spread* spread, uint64_t cost, uint64_t estimate) {
  if (policy.exceeded_once_in == 0 || estimate == 0 || cost / k_foreseeable >= estimate) return;
  if (cost > with_margin(policy, *spread, estimate)) {
    spread->ratio += k_spread_step;
    return;
  }
  const uint32_t lower = k_spread_step / policy.exceeded_once_in;
  if (spread->ratio >= k_spread_min + lower) spread->ratio -= lower;
}

void predictor_observe(Governor* governor, const WorkUnit& unit, uint64_t ns) {
  if (unit.kind >= k_unit_kinds) return;
  Governor::Kind* kind = &governor->kinds[unit.kind];
  const PredictorPolicy& policy = governor->policy;
  uint64_t cost = ns * k_picoseconds_per_nanosecond / (unit.items == 0 ? 1 : unit.items);
  if (cost == 0) cost = 1;
  if (kind->count >= k_censor_from) spread_observe(policy, &kind->spread, cost, kind->estimate);
  if (policy.censor != 0 && kind->count >= k_censor_from && cost / policy.censor >= kind->estimate) {
    cost = multiply(kind->estimate, policy.censor);
  }
  // A kind that was denied got its chance and was far cheaper than remembered: what is remembered no longer holds.
  if (policy.probe_frames != 0 && kind->frames_denied > 0 && cost < kind->estimate / 2) kind->count = kind->cursor = 0;

  const bool full = kind->count == k_history;
  const uint64_t replaced = kind->recent[kind->cursor];
  kind->recent[kind->cursor] = cost;
  kind->cursor = (kind->cursor + 1) % k_history;
  if (!full) ++kind->count;
  // Where the old cost and the new one lie on the same side of the estimate, the estimate stays. Most units are so.
  const bool unmoved = (replaced < kind->estimate && cost <= kind->estimate) || replaced == cost ||
                       (replaced > kind->estimate && cost >= kind->estimate);
  if (!full || !unmoved) kind->estimate = quantile(*kind, policy.dropped);
}

uint64_t governor_predict(const Governor* governor, uint32_t kind, uint64_t items) {
  if (kind >= k_unit_kinds) return 0;
  const Governor::Kind& known = governor->kinds[kind];
  const uint32_t halvings = known.frames_idle / k_idle_frames_per_halving;
  const uint64_t cost = halvings < 64 ? known.estimate >> halvings : 0;
  if (cost == 0 || items == 0) return 0;
  const uint64_t ns = add(multiply(cost / k_picoseconds_per_nanosecond, items),
                          multiply(cost % k_picoseconds_per_nanosecond, items) / k_picoseconds_per_nanosecond);
  return ns != 0 ? ns : 1;
}

}  // namespace sandglass
