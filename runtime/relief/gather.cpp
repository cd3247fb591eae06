// Samples into the cells below them. A cell takes the highest: what stands on it, not what is seen beside that.
#include "kernels/whole.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

// Metres. What is higher hangs over the plane. What is lower is seen past the plane's edge, or was measured badly, and
// says nothing of the cell: as holes such samples were wrong in 6 of 100.
constexpr float k_highest = 0.5f, k_lowest = -0.03f;

// Samples of one row.
void gather_row(const ReliefState& relief, uint32_t first, uint32_t count) {
  const ReliefView& view = relief.view;
  const ReliefRay start = relief_ray(view, first % view.width, first / view.width);
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
    const float height = view.position[1] + depth * (start.v[1] + aside * view.right[1]);
    if (!(height <= k_highest && height >= k_lowest)) continue;
    const float along = per_metre * depth, x = from[0] + along * (start.v[0] + aside * view.right[0]),
                z = from[1] + along * (start.v[2] + aside * view.right[2]);
    if (!(x >= 0.0f && x < width && z >= 0.0f && z < length)) continue;
    const uint32_t cell = to_whole<uint32_t>(z) * relief.desc.cells[0] + to_whole<uint32_t>(x);
    const auto whole = static_cast<int16_t>(floor_whole(height * k_relief_per_metre + 0.5f));
    if (whole > now[cell]) now[cell] = whole;
  }
}

}  // namespace

void relief_gather(const ReliefState& relief, uint32_t first, uint32_t end) {
  const uint32_t width = relief.view.width;
  for (uint32_t i = first; i < end;) {
    const uint32_t left = width - i % width, count = end - i < left ? end - i : left;
    gather_row(relief, i, count);
    i += count;
  }
}

}  // namespace sandglass
