// The oracles of the kernels that ask where colliders are: who wakes near one, who is inside, the surface of a field.
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

}  // namespace

void check_surface_at(uint32_t n) {
  // A field of waves that is turned by a quarter about z. Local x is world y, and local y is world -x.
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
      std::vector<SurfacePoint> found(cluster.inert + k_slack);
      std::memcpy(found.data(), cluster.records.data(), found.size() * sizeof(SurfacePoint));
      const SurfaceArgs args = {found.data(), &frame};
      run(kernels.surface_at, args, n);
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

}  // namespace sandglass::tests
