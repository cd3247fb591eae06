// The oracles of the kernels that ask where colliders are: who wakes near one, who is inside, the surface of a field and
// of a relief.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/kernels/oracles.h"

namespace sandglass::tests {

void check_wake_near(uint32_t n) {
  Cluster cluster(n, 0, 0.3, 41);
  mix(&cluster);
  const ColliderFrame colliders[2] = {upright(SANDGLASS_SHAPE_SPHERE, {0.01, 0, 0}, 0.02f),
                                      upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.03, 0})};
  const float margins[2] = {0.005f, 0.012f};
  std::vector<Sleeper> sleepers(cluster.inert + k_slack);
  std::memcpy(sleepers.data(), cluster.records.data(), sleepers.size() * sizeof(Sleeper));
  for (uint32_t i = 0; i < n; i += 3) sleepers[i].radius = 0.004f;
  on_every_table([&](const Kernels& kernels, SameBits& same) {
    std::vector<Sleeper> moved = sleepers;
    const WakeArgs args = {moved.data(), n, colliders, margins, 2};
    const uint32_t woken = run(kernels.wake_near, args, n);
    uint32_t expected = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const Sleeper& sleeper = sleepers[i];
      const Vector x = at(sleeper.position);
      const double ball = length(x - Vector{0.01, 0, 0}) - 0.02 - 0.005, floor = x.y + 0.03 - 0.012;
      const double gap = std::min(ball, floor) - static_cast<double>(sleeper.radius);
      ASSERT_GT(std::fabs(gap), 1e-8);
      const bool wakes = sleeper.mobility < 0.0f && gap < 0;
      expected += wakes ? 1 : 0;
      ASSERT_EQ(moved[i].mobility, wakes ? -sleeper.mobility : sleeper.mobility);
    }
    ASSERT_EQ(woken, expected);
    ASSERT_TRUE(same(moved));
  });
}

void check_find_inside(uint32_t n) {
  Cluster cluster(n, 0, 0.3, 43);
  const ColliderFrame shapes[2] = {upright(SANDGLASS_SHAPE_SPHERE, {0, 0, 0.02}, 0.015f),
                                   upright(SANDGLASS_SHAPE_HALF_SPACE, {0, -0.01, 0})};
  on_every_table([&](const Kernels& kernels) {
    std::vector<uint8_t> inside(cluster.rows, 7);
    const InsideArgs args = {as_records(cluster.records.data()), n, shapes, 2, inside.data()};
    const uint32_t found = run(kernels.find_inside, args, n);
    uint32_t expected = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const Vector x = at(cluster.records[i].position);
      const double gap = std::min(length(x - Vector{0, 0, 0.02}) - 0.015, x.y + 0.01);
      ASSERT_GT(std::fabs(gap), 1e-8);
      ASSERT_EQ(inside[i], gap < 0 ? 1 : 0);
      expected += gap < 0 ? 1 : 0;
    }
    ASSERT_EQ(found, expected);
  });
}

namespace {

// The value and gradient of the trilinear interpolant at a point within the grid, in double.
double trilinear(const FieldGrid& grid, Vector p, Vector* gradient) {
  const double at[3] = {(p.x - static_cast<double>(grid.low[0])) / static_cast<double>(grid.spacing),
                        (p.y - static_cast<double>(grid.low[1])) / static_cast<double>(grid.spacing),
                        (p.z - static_cast<double>(grid.low[2])) / static_cast<double>(grid.spacing)};
  uint32_t cell[3];
  double f[3], slope[3] = {0, 0, 0}, value = 0;
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::min(static_cast<uint32_t>(at[k]), grid.counts[k] - 2);
    f[k] = at[k] - cell[k];
  }
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const uint32_t d[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    const uint32_t index = (cell[0] + d[0]) + grid.counts[0] * ((cell[1] + d[1]) + grid.counts[1] * (cell[2] + d[2]));
    const double v = static_cast<double>(grid.values[index]);
    double weight[3], sign[3];
    for (int k = 0; k < 3; ++k) {
      weight[k] = d[k] != 0 ? f[k] : 1 - f[k];
      sign[k] = d[k] != 0 ? 1 : -1;
    }
    value += v * weight[0] * weight[1] * weight[2];
    for (int k = 0; k < 3; ++k) slope[k] += v * sign[k] * weight[(k + 1) % 3] * weight[(k + 2) % 3];
  }
  *gradient = (1 / std::sqrt(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2])) *
              Vector{slope[0], slope[1], slope[2]};
  return value;
}

// What the kernel tells of the places of a cluster.
std::vector<SurfacePoint> surfaces(const Kernels& kernels, const Cluster& cluster, const ColliderFrame& frame,
                                   uint32_t n) {
  std::vector<SurfacePoint> found(cluster.inert + k_slack);
  std::memcpy(found.data(), cluster.records.data(), found.size() * sizeof(SurfacePoint));
  const SurfaceArgs args = {found.data(), &frame};
  run(kernels.surface_at, args, n);
  return found;
}

// A field of waves that is turned by a quarter about z. Local x is world y, and local y is world -x.
void check_field(uint32_t n) {
  std::vector<float> values(7 * 6 * 5);
  for (size_t i = 0; i < values.size(); ++i) values[i] = 0.01f * std::sin(0.7f * static_cast<float>(i));
  ColliderFrame frame = {};
  frame.shape = SANDGLASS_SHAPE_FIELD;
  frame.axes[0][1] = 1.0f;
  frame.axes[1][0] = -1.0f;
  frame.axes[2][2] = 1.0f;
  frame.position[0] = 0.01f;
  for (const float outward : {1.0f, -1.0f}) {
    frame.field = {values.data(), {7, 6, 5}, {-0.03f, -0.025f, -0.02f}, 0.01f, 100.0f, outward, outward * 0.002f};
    Cluster cluster(n, 0, 0.1, 47);
    on_every_table([&](const Kernels& kernels, SameBits& same) {
      std::vector<SurfacePoint> found = surfaces(kernels, cluster, frame, n);
      for (uint32_t i = 0; i < n; ++i) {
        const Vector world = at(cluster.records[i].position) - Vector{static_cast<double>(frame.position[0]), 0, 0};
        const Vector local = {world.y, -world.x, world.z};
        const Vector near = {std::clamp(local.x, -0.03, 0.03), std::clamp(local.y, -0.025, 0.025),
                             std::clamp(local.z, -0.02, 0.02)};
        const double out = length(local - near);
        Vector normal;
        double distance;
        if (out > 1e-7) {
          normal = (static_cast<double>(outward) / out) * (local - near);
          distance = outward > 0 ? std::max(out, static_cast<double>(frame.field.border))
                                 : static_cast<double>(frame.field.border) - out;
        } else {
          distance = trilinear(frame.field, local, &normal);
        }
        const Vector turned = {-normal.y, normal.x, normal.z};
        ASSERT_NEAR(found[i].distance, distance, 1e-7) << "point " << i;
        ASSERT_LT(length(at(found[i].normal) - turned), 2e-4) << "point " << i;
      }
      found.resize(n);
      ASSERT_TRUE(same(found));
    });
  }
}

// A node of a relief: the outermost one where the place is beyond.
double height_of_node(const FieldGrid& grid, int x, int z) {
  const int i = std::clamp(x, 0, static_cast<int>(grid.counts[0]) - 1),
            j = std::clamp(z, 0, static_cast<int>(grid.counts[2]) - 1);
  return static_cast<double>(grid.values[static_cast<size_t>(j) * grid.counts[0] + static_cast<size_t>(i)]);
}

// Its height, metres, at a place in nodes: between four of them; beyond the outer ones it falls to 5 cm below 0 over a
// cell.
double relief_height(const FieldGrid& grid, double x, double z) {
  const double last[2] = {grid.counts[0] - 1.0, grid.counts[2] - 1.0};
  const double a = std::clamp(x, 0.0, last[0]), b = std::clamp(z, 0.0, last[1]);
  const int i = static_cast<int>(a), j = static_cast<int>(b);
  const double u = a - i, v = b - j;
  const double height = (1 - u) * ((1 - v) * height_of_node(grid, i, j) + v * height_of_node(grid, i, j + 1)) +
                        u * ((1 - v) * height_of_node(grid, i + 1, j) + v * height_of_node(grid, i + 1, j + 1));
  const double beyond = std::max(std::fabs(x - a), std::fabs(z - b));
  return height - beyond * (height + 0.05);
}

// A relief whose local y is world -x, as that field. The slope is a difference of heights about the point.
void check_relief(uint32_t n) {
  std::vector<float> heights(9 * 6 + 1);
  for (size_t i = 0; i < heights.size(); ++i) heights[i] = 0.02f * std::sin(0.9f * static_cast<float>(i));
  ColliderFrame frame = upright(SANDGLASS_SHAPE_RELIEF, {0.01, 0, 0});
  for (auto& axis : frame.axes)
    for (float& x : axis) x = 0;
  frame.axes[0][1] = frame.axes[2][2] = 1.0f;
  frame.axes[1][0] = -1.0f;
  frame.field = {heights.data(), {9, 1, 6}, {-0.04f, 0, -0.025f}, 0.01f, 100.0f, 1.0f, 0.0f};
  for (const float offset : {0.0f, 0.007f}) {
    frame.offset = offset;
    Cluster cluster(n, 0, 0.12, 53);
    uint32_t beyond = 0, falling = 0;
    on_every_table([&](const Kernels& kernels, SameBits& same) {
      std::vector<SurfacePoint> found = surfaces(kernels, cluster, frame, n);
      for (uint32_t i = 0; i < n; ++i) {
        const Vector world = at(cluster.records[i].position) - Vector{static_cast<double>(frame.position[0]), 0, 0};
        const double x = (world.y + 0.04) / 0.01, z = (world.z + 0.025) / 0.01, y = -world.x;
        const double out = std::max({-x, x - 8, -z, z - 5});
        falling += out > 0 && out < 1;
        beyond += out > 1;
        if (out > 1 + 1e-5) {
          ASSERT_GT(found[i].distance, 1000);
        }
        constexpr double k_small = 1e-4;  // cells: no edge of a cell is so near
        const double edges[] = {x - std::round(x), z - std::round(z), std::max(-x, x - 8) - std::max(-z, z - 5)};
        const bool smooth = std::all_of(edges, edges + 3, [](double e) { return std::fabs(e) > 2 * k_small; });
        if (out > 1 - 1e-5 || !smooth) continue;
        const double slope[2] = {
            (relief_height(frame.field, x + k_small, z) - relief_height(frame.field, x - k_small, z)) /
                (0.02 * k_small),
            (relief_height(frame.field, x, z + k_small) - relief_height(frame.field, x, z - k_small)) /
                (0.02 * k_small)};
        const double cosine = 1 / std::sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
        const auto raised = static_cast<double>(offset);
        const double distance = (y - relief_height(frame.field, x, z) - raised) * cosine + raised;
        ASSERT_NEAR(found[i].distance, distance, 2e-7) << "point " << i;
        const Vector turned = {-cosine, -cosine * slope[0], -cosine * slope[1]};
        ASSERT_LT(length(at(found[i].normal) - turned), 2e-4) << "point " << i;
      }
      found.resize(n);
      ASSERT_TRUE(same(found));
    });
    if (n > 100) {
      EXPECT_GT(std::min(beyond, falling), n / 50);
    }
  }
}

}  // namespace

void check_surface_at(uint32_t n) {
  check_field(n);
  check_relief(n);
}

}  // namespace sandglass::tests
