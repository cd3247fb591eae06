#include "tests/laboratory/relief/relief_take.h"

#include <algorithm>

#include "runtime/relief/relief.h"

namespace sandglass::host {

namespace {

// The mode of the votes.
float highest_peak(const ReliefState& relief) {
  uint32_t best = 0;
  for (uint32_t bin = 0; bin < k_relief_bins; ++bin)
    if (relief.view.votes[bin] > relief.view.votes[best]) best = bin;
  return k_relief_scale_min +
         (static_cast<float>(best) + 0.5f) * (k_relief_scale_max - k_relief_scale_min) / k_relief_bins;
}

}  // namespace

void take_image(cpp::Relief* relief, const sandglass_depth_image& image, Left left) {
  if (left == Left::nothing) {
    (void)relief->set_image(image);
    return;
  }
  ReliefState* r = &relief->get()->relief;
  if (!relief_take(r, image)) return;
  while (r->phase != ReliefPhase::idle) {
    const ReliefPhase before = r->phase;
    relief_run_unit(r);
    if (before == r->phase) continue;
    if (before == ReliefPhase::read && left == Left::lock) r->scale = 1;
    if (before == ReliefPhase::read && left == Left::lowest_peak) r->scale = highest_peak(*r);
    if (before != ReliefPhase::gather || left != Left::clearing) continue;
    for (uint32_t i = 0; i < relief_cells(*r); ++i)
      if (r->cells.now[i] != k_relief_none) r->cells.now[i] = std::max(r->cells.now[i], r->cells.median[i]);
  }
  for (uint32_t i = 0; left == Left::hysteresis && i < relief_cells(*r); ++i)
    if (r->cells.seen[i] >= k_relief_looks_min) relief_show(r, i, r->cells.median[i]);
  relief_end_change(r);
}

}  // namespace sandglass::host
