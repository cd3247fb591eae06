// The oracles of the light and the sky that columns of sand leave to a texel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/kernels/oracles.h"

namespace sandglass::tests {

namespace {

// Random columns in a grid of padded rows, with texels above it. Some are empty, thinly filled or in the air.
struct Columns {
  Columns(uint32_t n, uint32_t row_count, uint32_t room, uint32_t seed, bool last_row_stands)
      : count(n), rows(row_count), margin(room), pitch(whole_groups(n) + room), random(seed) {
    tops.assign(rows * pitch + 3 * k_lane_group, -1e30f);
    bottoms.assign(tops.size(), 1e30f);
    fills.assign(tops.size(), 0.0f);
    for (uint32_t v = 0; v < rows; ++v)
      for (uint32_t at = place(v, 0); at < place(v, n); ++at) {
        if (any() < 0.3) continue;
        tops[at] = static_cast<float>(0.05 + 0.1 * any());
        bottoms[at] = last_row_stands && v == rows - 1 ? 0.0f : static_cast<float>(0.06 * any() - 0.02);
        fills[at] = any() < 0.4 ? 1.0f : static_cast<float>(any());
      }
    receivers.resize(whole_groups(n));
    for (float& r : receivers) r = static_cast<float>(0.02 * any());
  }
  uint32_t place(uint32_t row, uint32_t column) const { return margin + row * pitch + column; }
  double any() { return unit(random); }

  uint32_t count, rows, margin, pitch;
  std::mt19937 random;
  std::uniform_real_distribution<double> unit{0, 1};
  std::vector<float> tops, bottoms, fills, receivers;
};

// What a walk over columns sees. `reached` is the slope up to which all is dark: a column closes its filled share of
// the way that is left up to its own top.
struct Skyline {
  double cap, reached, high = 0, low = 1e30;
  void add(const Columns& columns, uint32_t at, float receiver, float inverse_distance) {
    if (columns.tops[at] < 0) return;
    const double inverse = static_cast<double>(inverse_distance);
    const double slope = static_cast<double>(columns.tops[at] - receiver) * inverse;
    high = std::max(high, slope);
    reached += static_cast<double>(columns.fills[at]) * std::max(std::min(slope, cap) - reached, 0.0);
    low = std::min(low, static_cast<double>(columns.bottoms[at] - receiver) * inverse);
  }
};

// sin^2 of the angle of a slope.
double sine_squared(double slope) { return std::pow(std::sin(std::atan(slope)), 2); }

// ---- pile_light

// What the column above texel i adds to the share that its azimuth leaves.
double change_by_own_column(const Columns& columns, const PileAzimuth& azimuth, uint32_t i) {
  const uint32_t at = columns.place(2, i);
  if (!(columns.tops[at] > 0)) return 0;
  const double open = 1 - static_cast<double>(columns.fills[at]), powers[5] = {0, 0.25, 0.5, 1, 2};
  double change = 0;
  for (int k = 0; k < 5; ++k) change += static_cast<double>(azimuth.own[k]) * std::pow(open, powers[k]);
  const double near = static_cast<double>(azimuth.near_from) -
                      (static_cast<double>(columns.bottoms[at]) - static_cast<double>(columns.receivers[i])) *
                          static_cast<double>(azimuth.near_per_metre);
  return std::clamp(near, 0.0, 1.0) * change;
}

// The share of the azimuth that no column hides from texel i of row 2.
double light_of_azimuth(const Columns& columns, const PileAzimuth& azimuth, const std::vector<PileStep>& steps,
                        bool on_floor, uint32_t i) {
  const double foot = static_cast<double>(azimuth.foot), cap = static_cast<double>(azimuth.cap);
  Skyline seen = {cap, foot};
  const bool thin = on_floor && azimuth.thin != 0;
  for (uint32_t s = azimuth.last_step; s-- > azimuth.first_step + (thin ? 1 : 0);) {
    const int row = 2 + steps[s].rows, column = static_cast<int>(i) + steps[s].columns;
    if (row < 0 || row >= static_cast<int>(columns.rows) || column < 0 || column >= static_cast<int>(columns.count))
      continue;
    seen.add(columns, columns.place(static_cast<uint32_t>(row), static_cast<uint32_t>(column)), columns.receivers[i],
             steps[s].inverse_distance);
  }
  const double from = std::max(sine_squared(std::max(seen.low, 0.0)), static_cast<double>(azimuth.low)),
               to = std::min(sine_squared(seen.high), static_cast<double>(azimuth.high));
  const double dark = seen.high > foot ? (seen.reached - foot) / (std::min(seen.high, cap) - foot) : 0.0;
  const double left = 1 + (thin ? change_by_own_column(columns, azimuth, i) : 0.0);
  return std::clamp(left, 0.0, 1.0) *
         (static_cast<double>(azimuth.high - azimuth.low) - std::max(0.0, to - from) * dark);
}

// The light has two azimuths with random steps. On the floor the own column of one of them is a factor.
void check_pile_light_of(uint32_t n, bool on_floor) {
  Columns columns(n, 5, k_lane_group, 53, false);
  std::vector<PileStep> steps(12);
  for (PileStep& step : steps) {
    const int32_t rows = static_cast<int32_t>(7 * columns.any()) - 3,
                  across = static_cast<int32_t>(9 * columns.any()) - 4;
    step = {rows, across, static_cast<float>(20 + 60 * columns.any())};
  }
  // The slopes whose sin^2 are 0.2 and 0.83, 0.1 and 0.73.
  const PileAzimuth azimuths[2] = {
      {0.2f, 0.9f, 1.0f, 0.5f, 2.2096042f, 0, 5, {-0.6f, 0.1f, 0.2f, 0.25f, 0.05f}, 1.2f, 20.0f, 1},
      {0.1f, 0.8f, 0.7f, 0.33333333f, 1.6442943f, 5, 12, {}, 0, 0, 0}};
  const double total = 0.7 + 0.7 * 0.7;
  PileLightArgs args = {};
  args.tops = columns.tops.data() + columns.margin;
  args.bottoms = columns.bottoms.data() + columns.margin;
  args.fills = columns.fills.data() + columns.margin;
  args.pitch = columns.pitch;
  args.row = 2;
  args.sand_rows[1] = static_cast<int32_t>(columns.rows) - 1;
  args.sand_columns[1] = static_cast<int32_t>(n) - 1;
  args.receivers = columns.receivers.data();
  args.azimuths = azimuths;
  args.azimuth_count = 2;
  args.steps = steps.data();
  args.on_floor = on_floor ? 1 : 0;
  args.inverse_total = static_cast<float>(1 / total);
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    std::vector<float> shares(whole_groups(n));
    args.shares = shares.data();
    run(kernels.pile_light, args, whole_groups(n));
    for (uint32_t i = 0; i < n; ++i) {
      double sum = 0;
      for (const PileAzimuth& azimuth : azimuths)
        sum += static_cast<double>(azimuth.weight) * light_of_azimuth(columns, azimuth, steps, on_floor, i);
      ASSERT_NEAR(shares[i], std::min(sum / total, 1.0), 2e-6) << "texel " << i;
    }
    shares.resize(n);
    ASSERT_TRUE(same(shares));
  });
}

}  // namespace

void check_pile_light(uint32_t n) {
  for (const bool on_floor : {false, true}) check_pile_light_of(n, on_floor);
}

// ---- pile_sky

namespace {

// Sectors that walk steps which leave the columns on both sides; of the last one all columns stand on the floor.
struct Sky {
  static constexpr uint32_t k_sectors = 3, k_steps_each = 5;
  explicit Sky(Columns* columns) {
    for (uint32_t k = 0; k < k_sectors; ++k) {
      const bool in_air = k + 1 < k_sectors;
      for (uint32_t ring = 0; ring < 4; ++ring) {
        shares[k][ring] = 0.08 * columns->any();
        sectors[k].bends[ring] = static_cast<float>(shares[k][ring] - (ring > 0 ? shares[k][ring - 1] : 0.0));
      }
      sectors[k].first_step = k * k_steps_each;
      sectors[k].last_step = (k + 1) * k_steps_each;
      sectors[k].in_air = in_air;
      for (uint32_t s = 0; s < k_steps_each; ++s) {
        const uint32_t row = in_air ? s % columns->rows : columns->rows - 1;
        const int32_t across = static_cast<int32_t>(21 * columns->any()) - 10;
        steps.push_back({static_cast<int32_t>(columns->place(row, 0)) + across, -across,
                         static_cast<int32_t>(columns->count) - 1 - across,
                         static_cast<float>(3 + 40 * columns->any())});
      }
    }
  }
  // What is left of the light of texel i.
  double light(const Columns& columns, uint32_t i) const {
    double left = 1;
    for (uint32_t k = 0; k < k_sectors; ++k) {
      Skyline seen = {2, 0};
      const int texel = static_cast<int>(i);
      for (uint32_t s = sectors[k].first_step; s < sectors[k].last_step; ++s)
        if (texel >= steps[s].first && texel <= steps[s].last)
          seen.add(columns, static_cast<uint32_t>(steps[s].at + texel), columns.receivers[i],
                   steps[s].inverse_distance);
      if (!(seen.high > 0)) continue;
      for (uint32_t ring = 0; ring < 4; ++ring) {
        const auto part = [&](double slope) { return std::clamp(4 * sine_squared(slope) - ring, 0.0, 1.0); };
        const double hidden = std::max(part(seen.high) - part(std::max(seen.low, 0.0)), 0.0);
        left -= shares[k][ring] * hidden * seen.reached / std::min(seen.high, 2.0);
      }
    }
    return std::max(left, 0.0);
  }
  PileSector sectors[k_sectors];
  double shares[k_sectors][4];
  std::vector<PileSkyStep> steps;
};

}  // namespace

void check_pile_sky(uint32_t n) {
  Columns columns(n, 4, 2 * k_lane_group, 59, true);
  const Sky sky(&columns);
  PileSkyArgs args = {};
  args.tops = columns.tops.data();
  args.bottoms = columns.bottoms.data();
  args.fills = columns.fills.data();
  args.steps = sky.steps.data();
  args.sectors = sky.sectors;
  args.sector_count = Sky::k_sectors;
  args.cap = 2.0f;
  args.receivers = columns.receivers.data();
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    std::vector<float> lights(whole_groups(n));
    args.lights = lights.data();
    run(kernels.pile_sky, args, whole_groups(n));
    for (uint32_t i = 0; i < n; ++i) ASSERT_NEAR(lights[i], sky.light(columns, i), 2e-6) << "texel " << i;
    lights.resize(n);
    ASSERT_TRUE(same(lights));
  });
}

}  // namespace sandglass::tests
