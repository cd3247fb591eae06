// Counts to bytes. Where counts change slowly they are steps of one direction each, which the eye sees as bands: there
// a texel becomes the mean of a window. Where they change fast they are an edge and stay. Windows of 3, 5 and 9 texels
// follow each other, each on the result of the one before.
#include <cstring>

#include "kernels/whole.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr uint32_t k_window_radius[] = {1, 2, 4};
constexpr uint32_t k_passes = 3;
constexpr float k_shade = 1.02f;  // times what is left there: more than a texture can say

float* row_of(const CastCalm& calm, uint32_t texels, uint32_t row) {
  return calm.values + uint64_t{row} * cast_pitch(texels) + k_lane_group;
}

// Eight counts from eight bits of each plane.
uint64_t eight_counts(const uint64_t* counts, uint64_t words, uint64_t word, uint32_t byte) {
  uint64_t sums = 0;
  for (uint32_t plane = 0; plane < k_cast_planes; ++plane) {
    const uint64_t bits = counts[plane * words + word] >> (8 * byte) & 0xff;
    sums += (bits * 0x8040201008040201u >> 7 & 0x0101010101010101u) << plane;  // bit 7 comes first
  }
  return __builtin_bswap64(sums);
}

// How many directions of a texel are hidden, and how many of those that real things hide are none of these.
struct Hidden {
  float by_virtual, by_real;
};

void read_counts(const CastState& c, uint32_t light, uint64_t words, uint64_t word, uint32_t byte, Hidden out[8]) {
  const uint64_t at = c.calm.layer * k_cast_planes * words;
  const uint64_t hidden = eight_counts(c.drawing.counts[light] + at, words, word, byte);
  const uint64_t masked =
      cast_masks(c.gathered) ? eight_counts(c.drawing.mask_counts[light] + at, words, word, byte) : 0;
  for (uint32_t i = 0; i < 8; ++i)
    out[i] = {static_cast<float>(hidden >> (8 * i) & 0xff), static_cast<float>(masked >> (8 * i) & 0xff)};
}

// A row of counts. What real things hide does not count: of the directions that they leave, as many are hidden as if
// all were left. Where the shares of both lights are known, of what they leave of both: a thing in the shade of a house
// hides the sky, which is all the light that is there. Of that, each texture says at most its own light's share, so
// what the other cannot say is added.
void read_row(CastCalm* calm, const CastState& c, uint32_t texels, uint32_t row) {
  const CastDrawing& drawing = c.drawing;
  const uint64_t words = uint64_t{texels} * cast_words(texels);
  const float all = static_cast<float>(drawing.direction_count);
  const float others = static_cast<float>(drawing.other_count);
  const float share = static_cast<float>(c.progress.target == k_cast_light ? drawing.share : 1 - drawing.share),
              rest = 1 - share;
  float* values = row_of(*calm, texels, row);
  Hidden own[8], other[8] = {};
  for (uint32_t u = 0; u < texels; u += 8) {
    const uint64_t word = uint64_t{row} * cast_words(texels) + u / 64;
    read_counts(c, 0, words, word, u / 8 % 8, own);
    if (drawing.other_count != 0) read_counts(c, 1, words, word, u / 8 % 8, other);
    for (uint32_t i = 0; i < 8; ++i) {
      const auto [count, masked] = own[i];
      const float left = all - masked;
      values[u + i] = masked > 0 ? (left > 0 ? count * all / left : 0) : count;
      if (drawing.other_count == 0 || !(masked + other[i].by_real > 0)) continue;
      const float before = share * left / all + rest * (others - other[i].by_real) / others;
      const float excess = rest * (other[i].by_virtual / others - before);
      const float taken = share * count / all + (excess > 0 ? excess : 0);
      values[u + i] = before > 0 ? all * (taken < share * before ? taken / (share * before) : 1) : 0;
      calm->shade_found = calm->shade_found || count > k_shade * before * all;
    }
  }
}

void window_row(const CastCalm& calm, const Kernels& kernels, uint32_t texels, uint32_t row, uint32_t radius) {
  float* values = row_of(calm, texels, row);
  for (uint32_t k = 1; k <= radius; ++k) {
    *(values - k) = values[0];
    values[texels - 1 + k] = values[texels - 1];
  }
  CastWindowArgs args = {};
  args.row = values;
  args.radius = radius;
  const uint64_t at = uint64_t{row % k_cast_rows} * texels;
  args.low = calm.windows[0] + at;
  args.high = calm.windows[1] + at;
  args.sum = calm.windows[2] + at;
  uint32_t unused = 0;
  kernels.cast_window(&args, 0, texels, &unused);
}

void calm_row(const CastCalm& calm, const CastState& c, uint32_t texels, uint32_t row, uint32_t radius) {
  CastCalmArgs args = {};
  args.rows = 2 * radius + 1;
  for (uint32_t k = 0; k < args.rows; ++k) {
    const uint32_t wanted = row + k < radius ? 0 : row + k - radius, last = texels - 1;
    const uint64_t at = uint64_t{(wanted < last ? wanted : last) % k_cast_rows} * texels;
    args.low[k] = calm.windows[0] + at;
    args.high[k] = calm.windows[1] + at;
    args.sum[k] = calm.windows[2] + at;
  }
  args.difference_max = c.drawing.direction_count > k_cast_draft_directions ? 8.0f : 2.0f;
  args.row = row_of(calm, texels, row);
  uint32_t unused = 0;
  c.kernels->cast_calm(&args, 0, texels, &unused);
}

// The share that is drawn of what fades towards the low and the high side.
float faded(const float fade[2], uint32_t i, uint32_t texels) {
  const float low = static_cast<float>(i) / (fade[0] > 1 ? fade[0] : 1.0f);
  const float high = static_cast<float>(texels - 1 - i) / (fade[1] > 1 ? fade[1] : 1.0f);
  return (fade[0] > 0 && low < 1 ? low : 1.0f) * (fade[1] > 0 && high < 1 ? high : 1.0f);
}

// Light: the share that is hidden. Ambient: 1 less that share of the light that the cells are.
void write_row(const CastState& c, uint32_t texels, uint32_t row, uint8_t* bytes) {
  const bool ambient = c.progress.target == k_cast_ambient;
  double sum = 0;
  for (const float cell : c.drawing.cells) sum += static_cast<double>(cell);
  const uint32_t directions = c.drawing.direction_count;
  const float hidden = directions != 0 ? 255.0f / static_cast<float>(directions) : 0.0f;
  const float scale = ambient ? hidden * static_cast<float>(sum < 1 ? sum : 1) : hidden;
  const float* values = row_of(c.calm, texels, row);
  const float(*fade)[2] = c.targets[c.progress.target].back.fade;
  for (uint32_t u = 0; u < texels; ++u) {
    float value = scale * values[u];
    value *= faded(fade[1], row, texels) * faded(fade[0], u, texels);
    if (ambient) value = 255.0f - value;
    bytes[u] = static_cast<uint8_t>(to_whole<uint32_t>((value < 255.0f ? value : 255.0f) + 0.5f));
  }
}

}  // namespace

void cast_begin_calm(CastCalm* calm) {
  calm->layer = calm->pass = calm->row = 0;
  calm->shade_found = false;
}

bool cast_calm(CastCalm* calm, uint8_t* bytes, const CastState& c) {
  const uint32_t texels = c.targets[c.progress.target].texels, rows = k_cast_unit_texels / texels;
  for (uint32_t done = 0; done < rows && calm->layer < c.desc.layers; ++done) {
    const uint32_t radius = k_window_radius[calm->pass];
    if (calm->row < texels) {
      if (calm->pass == 0) read_row(calm, c, texels, calm->row);
      window_row(*calm, *c.kernels, texels, calm->row, radius);
    }
    if (calm->row >= radius) {
      const uint32_t ready = calm->row - radius;
      calm_row(*calm, c, texels, ready, radius);
      if (calm->pass == k_passes - 1)
        write_row(c, texels, ready, bytes + (uint64_t{calm->layer} * texels + ready) * texels);
    }
    if (++calm->row < texels + radius) continue;
    calm->row = 0;
    if (++calm->pass < k_passes) continue;
    calm->pass = 0;
    ++calm->layer;
  }
  return calm->layer == c.desc.layers;
}

}  // namespace sandglass
