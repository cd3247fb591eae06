// Samples into the cells below them. A cell takes the highest: what stands on it, not what is seen beside that.
#include "kernels/whole.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

// Samples of one row.
void gather_row(const ReliefState& relief, uint32_t first, uint32_t count) {
  const ReliefView& view = relief.view;
  float start[3];
  relief_ray(view, first % view.width, first / view.width, start);
  const float step = static_cast<float>(view.step), width = static_cast<float>(relief.desc.cells[0]),
              length = static_cast<float>(relief.desc.cells[1]);
  const float per_metre = relief.per_metre, unit = k_sample_unit * relief.scale;
  const float from[2] = {view.position[0] * per_metre + relief.middle[0],
                         view.position[2] * per_metre + relief.middle[1]};
  int16_t* const now = relief.cells.now;
  for (uint32_t i = 0; i < count; ++i) {
    const uint16_t sample = relief.samples[first + i];
    if (sample == 0 || sample >= k_sample_rejected) continue;
    const float depth = static_cast<float>(sample) * unit, aside = static_cast<float>(i) * step;
    const float height = k_relief_per_metre * (view.position[1] + depth * (start[1] + aside * view.right[1])) + 0.5f;
    if (!(height < k_relief_highest && height >= k_relief_lowest)) continue;
    const float along = per_metre * depth, x = from[0] + along * (start[0] + aside * view.right[0]),
                z = from[1] + along * (start[2] + aside * view.right[2]);
    if (!(x >= 0.0f && x < width && z >= 0.0f && z < length)) continue;
    const uint32_t cell = to_whole<uint32_t>(z) * relief.desc.cells[0] + to_whole<uint32_t>(x);
    const auto whole = static_cast<int16_t>(floor_whole(height));
    if (whole > now[cell]) now[cell] = whole;
  }
}

}  // namespace

void relief_gather(const ReliefState& relief, uint32_t first, uint32_t end) {
  relief_for_rows(first, end, relief.view.width, k_relief_unit_samples,
                  [&](uint32_t from, uint32_t count) { gather_row(relief, from, count); });
}

}  // namespace sandglass
