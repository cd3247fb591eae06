// The oracles of casts: which texels triangles hide, and the filter of calm counts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "tests/kernels/oracles.h"

namespace sandglass::tests {

namespace {

constexpr uint32_t k_texels = 128, k_words = k_texels / 64;
constexpr float k_offset[2] = {63.2f, 60.9f};

// Whether triangles hide the middle of a texel; nothing where an edge is too near to tell.
std::optional<bool> is_hidden(const std::vector<float> (&corners)[9], uint32_t n, bool closed, uint32_t u, uint32_t v) {
  bool near_edge = false;
  for (uint32_t i = 0; i < n; ++i) {
    double p[3][2];
    for (uint32_t c = 0; c < 3; ++c) {
      const double x = static_cast<double>(corners[3 * c][i]), y = static_cast<double>(corners[3 * c + 1][i]),
                   z = static_cast<double>(corners[3 * c + 2][i]);
      p[c][0] = x * 70.0 - y * 25.0 + static_cast<double>(k_offset[0]) - u;
      p[c][1] = z * 60.0 + y * 14.0 + static_cast<double>(k_offset[1]) - v;
    }
    const double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
    if (closed && area > 1e-3) continue;
    double inwards = 1e9;  // the distance of the middle from the edges, inwards
    for (uint32_t e = 0; e < 3; ++e) {
      const double *a = p[e], *b = p[(e + 1) % 3], cross = a[0] * b[1] - a[1] * b[0];
      inwards = std::min(inwards, (area < 0 ? -cross : cross) / std::hypot(b[0] - a[0], b[1] - a[1]));
    }
    if (inwards > 1e-4) return true;
    near_edge = near_edge || std::fabs(inwards) <= 1e-4 || std::fabs(area) <= 1e-3;
  }
  return near_edge ? std::nullopt : std::optional(false);
}

}  // namespace

// Triangles of all sizes, some of which leave the image; every one is tested against every texel's middle.
void check_cast_triangles(uint32_t n) {
  std::mt19937 random(67);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<float> corners[9];
  for (auto& array : corners) array.assign(whole_groups(n) + k_lane_group, 0.0f);
  for (uint32_t i = 0; i < n; ++i) {
    const double size = i % 3 == 0 ? 0.5 : 0.03, x = unit(random), y = 0.3 + 0.3 * unit(random), z = unit(random);
    for (uint32_t c = 0; c < 3; ++c) {
      corners[3 * c][i] = static_cast<float>(x + size * unit(random));
      corners[3 * c + 1][i] = static_cast<float>(y + 0.2 * size * unit(random));
      corners[3 * c + 2][i] = static_cast<float>(z + size * unit(random));
    }
  }
  CastTrianglesArgs args = {};
  for (uint32_t c = 0; c < 9; ++c) args.corners[c] = corners[c].data();
  const float scale[2] = {70, 60}, shear[2] = {25, -14};
  std::copy_n(scale, 2, args.scale);
  std::copy_n(shear, 2, args.shear);
  std::copy_n(k_offset, 2, args.offset);
  args.texels = k_texels;
  args.words = k_words;
  for (const uint32_t closed : {0u, 1u}) {
    args.closed = closed;
    std::vector<uint64_t> image;
    SameBits same_image, same_extent;
    on_every_table([&](const Kernels& kernels) {
      image.assign(k_texels * k_words, 0);
      args.image = image.data();
      CastExtent extent = {0, 0, ~0u, 0};
      kernels.cast_triangles(&args, 0, whole_groups(n), &extent);
      ASSERT_TRUE(same_image(image));
      ASSERT_TRUE(same_extent(std::vector{extent}));
    });
    uint32_t certain = 0;
    for (uint32_t v = 0; v < k_texels; ++v)
      for (uint32_t u = 0; u < k_texels; ++u) {
        const std::optional<bool> hidden = is_hidden(corners, n, closed != 0, u, v);
        if (!hidden) continue;
        ++certain;
        ASSERT_EQ(image[v * k_words + u / 64] >> (u % 64) & 1, *hidden ? 1u : 0u)
            << u << " " << v << " closed " << closed;
      }
    ASSERT_GT(certain, k_texels * k_texels * 9 / 10);
  }
}

namespace {

std::vector<float> counts_of(uint32_t n, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<float> counts(n + 4 * k_lane_group);
  for (float& count : counts) count = static_cast<float>(random() % 12);
  return counts;
}

}  // namespace

void check_cast_window(uint32_t n) {
  const uint32_t padded = whole_groups(n);
  const std::vector<float> row = counts_of(padded, 71);
  for (const uint32_t radius : {1u, 2u, 4u})
    on_every_table([&](const Kernels& kernels) {
      std::vector<float> low(padded), high(padded), sum(padded);
      const CastWindowArgs args = {row.data() + k_lane_group, radius, low.data(), high.data(), sum.data()};
      run(kernels.cast_window, args, padded);
      for (uint32_t i = 0; i < n; ++i) {
        const auto from = row.begin() + k_lane_group + i - radius, to = from + 2 * radius + 1;
        ASSERT_EQ(low[i], *std::min_element(from, to));
        ASSERT_EQ(high[i], *std::max_element(from, to));
        ASSERT_EQ(sum[i], std::accumulate(from, to, 0.0f));  // whole numbers: exact
      }
    });
}

void check_cast_calm(uint32_t n) {
  const uint32_t padded = whole_groups(n);
  for (const uint32_t rows : {3u, 5u, 9u}) {
    std::vector<float> low[k_cast_rows], high[k_cast_rows], sum[k_cast_rows];
    CastCalmArgs args = {};
    for (uint32_t k = 0; k < rows; ++k) {
      low[k] = counts_of(padded, k);
      high[k] = low[k];
      sum[k] = counts_of(padded, 100 + k);
      for (float& x : high[k]) x += static_cast<float>(k % 4);
      args.low[k] = low[k].data();
      args.high[k] = high[k].data();
      args.sum[k] = sum[k].data();
    }
    args.rows = rows;
    args.difference_max = 8;
    const std::vector<float> before = counts_of(padded, 73);
    on_every_table([&](const Kernels& kernels, SameBits& same) {
      std::vector<float> row = before;
      args.row = row.data();
      run(kernels.cast_calm, args, padded);
      for (uint32_t i = 0; i < n; ++i) {
        double lowest = 1e9, highest = -1e9, all = 0;
        for (uint32_t k = 0; k < rows; ++k) {
          lowest = std::min(lowest, static_cast<double>(low[k][i]));
          highest = std::max(highest, static_cast<double>(high[k][i]));
          all += static_cast<double>(sum[k][i]);
        }
        const double share = std::clamp(2 - (highest - lowest) / 4, 0.0, 1.0), x = static_cast<double>(before[i]);
        ASSERT_NEAR(row[i], x + share * (all / (rows * rows) - x), 1e-5);
      }
      row.resize(n);
      ASSERT_TRUE(same(row));
    });
  }
}

}  // namespace sandglass::tests
