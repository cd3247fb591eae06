// The app's pixels into samples. A pixel beside a step may be a mean of near and far, which is nowhere: it is rejected,
// but it still says how far one sees there. All others vote for the plane.
//
// A depth camera is wrong by some per cent of the depth, and by another share each second. The plane, where the tracker
// has it, tells by how much: each pixel votes for the factor that would put it on the plane. What stands on the plane
// votes for more, and a book may have more votes than the table. So the lowest peak is taken, not the highest.
#include <cstring>

#include "kernels/whole.h"
#include "runtime/relief/relief.h"

namespace sandglass {
namespace {

constexpr float k_far = 4.0f;           // metres; noise grows with the square of the depth
constexpr float k_step_slope = 3.5f;    // depths over focal lengths: what a surface seen at 74 degrees rises in a pixel
constexpr float k_step_noise = 0.004f;  // metres
constexpr float k_steep = 0.15f;  // a ray that falls by less for a metre of depth meets the plane too flatly to vote
constexpr uint32_t k_votes_min = 200;
// Bins on either side: a peak is the mean of these, and the highest of those.
constexpr uint32_t k_smooth = 6, k_apart = 9;
constexpr uint32_t k_peak_share = 12;  // of a hundred votes; a peak has as many at least
constexpr float k_follows = 0.15f;     // share by which the scale moves towards that of one image
constexpr float k_bins_per_scale = static_cast<float>(k_relief_bins) / (k_relief_scale_max - k_relief_scale_min);

const uint8_t* at(const void* rows, int32_t stride, uint32_t y) {
  return static_cast<const uint8_t*>(rows) + static_cast<int64_t>(stride) * y;
}

// Metres; 0: unknown.
float depth_at(const sandglass_depth_image& image, uint32_t x, uint32_t y) {
  const uint8_t* row = at(image.depth, image.stride, y);
  float depth;
  if (image.format == SANDGLASS_DEPTH_U16) {
    uint16_t value;
    memcpy(&value, row + sizeof value * x, sizeof value);
    depth = static_cast<float>(value) * image.to_metres;
  } else {
    memcpy(&depth, row + sizeof depth * x, sizeof depth);
    depth = depth * image.to_metres;
  }
  return depth > 0.0f && depth <= k_far ? depth : 0.0f;
}

bool counts(const sandglass_depth_image& image, uint32_t x, uint32_t y) {
  if (image.confidence != nullptr && at(image.confidence, image.confidence_stride, y)[x] < image.confidence_min)
    return false;
  return image.mask == nullptr || at(image.mask, image.mask_stride, y)[x] == 0;
}

// Whether a neighbour lies on another surface, or nowhere.
bool beside_step(const sandglass_depth_image& image, uint32_t x, uint32_t y, float depth) {
  const float aside = k_step_slope * depth / image.focal_x + k_step_noise,
              below = k_step_slope * depth / image.focal_y + k_step_noise;
  const auto leaps = [&](uint32_t nx, uint32_t ny, float most) {
    const float step = depth_at(image, nx, ny) - depth;
    return step > most || step < -most;
  };
  return (x > 0 && leaps(x - 1, y, aside)) || (x + 1 < image.width && leaps(x + 1, y, aside)) ||
         (y > 0 && leaps(x, y - 1, below)) || (y + 1 < image.height && leaps(x, y + 1, below));
}

void vote(ReliefView* view, const ReliefState& relief, const ReliefRay& ray, float depth) {
  if (!(ray.v[1] < -k_steep)) return;
  const float on_plane = -view->position[1] / ray.v[1], scale = on_plane / depth;
  if (!(scale > k_relief_scale_min && scale < k_relief_scale_max)) return;
  for (uint32_t k = 0; k < 2; ++k) {
    const float along = (view->position[2 * k] + on_plane * ray.v[2 * k]) * relief.per_metre + relief.middle[k];
    if (!(along >= 0.0f && along < static_cast<float>(relief.desc.cells[k]))) return;
  }
  const auto bin = to_whole<uint32_t>((scale - k_relief_scale_min) * k_bins_per_scale);
  ++view->votes[bin < k_relief_bins ? bin : k_relief_bins - 1];
  ++view->vote_count;
}

}  // namespace

void relief_read(ReliefView* view, const ReliefState& relief, uint32_t first, uint32_t end) {
  const sandglass_depth_image& image = view->image;
  for (uint32_t i = first; i < end; ++i) {
    const uint32_t column = i % view->width, row = i / view->width, x = column * view->step, y = row * view->step;
    const float depth = depth_at(image, x, y);
    uint16_t sample = 0;
    if (depth > 0.0f && counts(image, x, y)) {
      sample = to_whole<uint16_t>(depth * (1.0f / k_sample_unit) + 0.5f);
      if (beside_step(image, x, y, depth)) sample |= k_sample_rejected;
      else vote(view, relief, relief_ray(*view, column, row), depth);
    }
    relief.samples[i] = sample;
  }
}

void relief_find_scale(ReliefState* relief) {
  const ReliefView& view = relief->view;
  if (view.vote_count < k_votes_min) return;
  const auto around = [&](uint32_t bin) {
    uint32_t sum = 0;
    for (uint32_t b = bin - k_smooth; b <= bin + k_smooth; ++b) sum += view.votes[b];
    return sum;
  };
  constexpr uint32_t k_first = k_smooth, k_end = k_relief_bins - k_smooth;
  for (uint32_t bin = k_first; bin < k_end; ++bin) {
    const uint32_t votes = around(bin);
    if (100 * votes < k_peak_share * view.vote_count) continue;
    bool peak = true;
    for (uint32_t b = bin > k_first + k_apart ? bin - k_apart : k_first; b < k_end && b <= bin + k_apart; ++b)
      peak = peak && around(b) <= votes;
    if (!peak) continue;
    uint32_t middles = 0;  // twice the bins' middles
    for (uint32_t b = bin - k_smooth; b <= bin + k_smooth; ++b) middles += view.votes[b] * (2 * b + 1);
    const float found =
        k_relief_scale_min + 0.5f * static_cast<float>(middles) / static_cast<float>(votes) * (1.0f / k_bins_per_scale);
    relief->scale = relief->scale_known ? relief->scale + k_follows * (found - relief->scale) : found;
    relief->scale_known = true;
    return;
  }
}

}  // namespace sandglass
