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
constexpr uint32_t k_votes_each = 4, k_votes_min = 50;  // one sample of four votes
// Bins on either side: a peak is the mean of these, and the highest of those.
constexpr uint32_t k_smooth = 6, k_apart = 9;
constexpr uint32_t k_peak_share = 12;  // of a hundred votes; a peak has as many at least
constexpr float k_follows = 0.15f;     // share by which the scale moves towards that of one image
constexpr float k_bins_per_scale = static_cast<float>(k_relief_bins) / (k_relief_scale_max - k_relief_scale_min);

const uint8_t* at(const void* rows, int32_t stride, uint32_t y) {
  return static_cast<const uint8_t*>(rows) + static_cast<int64_t>(stride) * y;
}

// The depths of pixels in a row, metres; 0: unknown.
template <class Stored>
void read_row(const sandglass_depth_image& image, const uint8_t* from, uint32_t count, float* depths) {
  const float to_metres = image.to_metres;
  for (uint32_t i = 0; i < count; ++i) {
    Stored stored;
    memcpy(&stored, from + sizeof stored * i, sizeof stored);
    const float depth = static_cast<float>(stored) * to_metres;
    depths[i] = depth > 0.0f && depth <= k_far ? depth : 0.0f;
  }
}

// A row of pixels and those above and below it, with one more at either end. Beyond the image lies what is at its edge.
constexpr uint32_t k_read_pixels = 256;
struct Pixels {
  float rows[3][k_read_pixels + 2];
};
void read_pixels(const sandglass_depth_image& image, uint32_t x, uint32_t y, uint32_t count, Pixels* pixels) {
  const uint32_t before = x > 0 ? 1 : 0, after = x + count < image.width ? 1 : 0;
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t row = k == 0 && y == 0 ? 0 : y + k - 1, there = row < image.height ? row : image.height - 1;
    float* depths = pixels->rows[k];
    const bool floats = image.format == SANDGLASS_DEPTH_F32;
    const uint8_t* from = at(image.depth, image.stride, there) + (x - before) * (floats ? 4 : 2);
    (floats ? read_row<float> : read_row<uint16_t>)(image, from, before + count + after, depths + 1 - before);
    if (before == 0) depths[0] = depths[1];
    if (after == 0) depths[count + 1] = depths[count];
  }
}

bool counts(const sandglass_depth_image& image, uint32_t x, uint32_t y) {
  if (image.confidence != nullptr && at(image.confidence, image.confidence_stride, y)[x] < image.confidence_min)
    return false;
  return image.mask == nullptr || at(image.mask, image.mask_stride, y)[x] == 0;
}

// Whether a neighbour of a pixel lies on another surface, or nowhere. i: from the first pixel on.
bool beside_step(const sandglass_depth_image& image, const Pixels& pixels, uint32_t i) {
  const float *row = pixels.rows[1] + i, depth = row[1];
  const auto largest = [depth](float a, float b) {
    const float first = __builtin_fabsf(a - depth), second = __builtin_fabsf(b - depth);
    return first > second ? first : second;
  };
  const float slope = k_step_slope * depth;
  return largest(row[0], row[2]) > slope / image.focal_x + k_step_noise ||
         largest(pixels.rows[0][i + 1], pixels.rows[2][i + 1]) > slope / image.focal_y + k_step_noise;
}

void vote(ReliefView* view, const ReliefState& relief, uint32_t column, uint32_t row, float depth) {
  float ray[3];
  relief_ray(*view, column, row, ray);
  if (!(ray[1] < -k_steep)) return;
  const float on_plane = -view->position[1] / ray[1], scale = on_plane / depth;
  if (!(scale > k_relief_scale_min && scale < k_relief_scale_max)) return;
  for (uint32_t k = 0; k < 2; ++k) {
    const float along = (view->position[2 * k] + on_plane * ray[2 * k]) * relief.per_metre + relief.middle[k];
    if (!(along >= 0.0f && along < static_cast<float>(relief.desc.cells[k]))) return;
  }
  const auto bin = to_whole<uint32_t>((scale - k_relief_scale_min) * k_bins_per_scale);
  ++view->votes[bin < k_relief_bins ? bin : k_relief_bins - 1];
  ++view->vote_count;
}

}  // namespace

void relief_read(ReliefView* view, const ReliefState& relief, uint32_t first, uint32_t end) {
  const sandglass_depth_image& image = view->image;
  Pixels pixels;
  relief_for_rows(first, end, view->width, k_read_pixels / view->step, [&](uint32_t from, uint32_t count) {
    const uint32_t column = from % view->width, row = from / view->width, x = column * view->step, y = row * view->step;
    read_pixels(image, x, y, (count - 1) * view->step + 1, &pixels);
    for (uint32_t k = 0; k < count; ++k) {
      const uint32_t pixel = k * view->step;
      const float depth = pixels.rows[1][pixel + 1];
      uint16_t sample = 0;
      if (depth > 0.0f && counts(image, x + pixel, y)) {
        sample = static_cast<uint16_t>(to_whole<uint32_t>(depth * (1.0f / k_sample_unit) + 0.5f));
        if (beside_step(image, pixels, pixel)) sample |= k_sample_rejected;
        else if ((column + k + row) % k_votes_each == 0) vote(view, relief, column + k, row, depth);
      }
      relief.samples[from + k] = sample;
    }
  });
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
