// Samples into the cells below them. A cell takes the highest: what stands on it, not what is seen beside that.
#include "kernels/whole.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

// Metres. What is higher hangs over the plane. What is lower is seen past the plane's edge, or was measured badly, and
// says nothing of the cell: as holes such samples were wrong in 6 of 100.
constexpr float k_highest = 0.5f, k_lowest = -0.03f;

}  // namespace

void relief_gather(const ReliefState& relief, uint32_t first, uint32_t end) {
  const ReliefView& view = relief.view;
  for (uint32_t i = first; i < end; ++i) {
    const uint16_t sample = relief.samples[i];
    if (sample == 0 || (sample & k_sample_rejected) != 0) continue;
    const float depth = static_cast<float>(sample) * k_sample_unit * relief.scale;
    const ReliefRay ray = relief_ray(view, i % view.width, i / view.width);
    const float height = view.position[1] + depth * ray.v[1];
    if (!(height <= k_highest && height >= k_lowest)) continue;
    uint32_t cell[2];
    bool inside = true;
    for (uint32_t k = 0; k < 2; ++k) {
      const float along = (view.position[2 * k] + depth * ray.v[2 * k]) * relief.per_metre + relief.middle[k];
      inside = inside && along >= 0.0f && along < static_cast<float>(relief.desc.cells[k]);
      cell[k] = to_whole<uint32_t>(along);
    }
    if (!inside) continue;
    const auto whole = static_cast<int16_t>(floor_whole(height * k_relief_per_metre + 0.5f));
    int16_t* now = &relief.cells[cell[1] * relief.desc.cells[0] + cell[0]].now;
    if (whole > *now) *now = whole;
  }
}

}  // namespace sandglass
