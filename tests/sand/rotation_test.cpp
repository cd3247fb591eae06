// The nearest rotation of matrices with known singular values: the best trace is s1 + s2 + sign(det A) s3.
#include "runtime/math/rotation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace {

using Matrix = std::array<double, 9>;  // row-major
using Quaternion = std::array<double, 4>;

constexpr Quaternion k_identity = {0, 0, 0, 1};

Matrix rotation_matrix(const Quaternion& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
}

Matrix product(const Matrix& a, const Matrix& b, bool transpose_first) {
  Matrix c = {};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) c[3 * i + j] += (transpose_first ? a[3 * k + i] : a[3 * i + k]) * b[3 * k + j];
  return c;
}

double determinant(const Matrix& a) {
  return a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6]) + a[2] * (a[3] * a[7] - a[4] * a[6]);
}

double trace_with(const Quaternion& q, const Matrix& a) {
  const Matrix r = rotation_matrix(q);
  double sum = 0;
  for (size_t i = 0; i < 9; ++i) sum += r[i] * a[i];
  return sum;
}

// Turned and stretched by known factors, of which only the smallest may be negative: the best trace is their sum.
TEST(Rotation, IsTheBestOneAtAnyScaleFromAnyStart) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto any = [&] {
    Quaternion q = {};
    double length = 0;
    for (double& v : q) {
      v = normal(random);
      length += v * v;
    }
    for (double& v : q) v /= std::sqrt(length);
    return q;
  };
  for (const auto& [x, y, z] : {std::array{3.0, 2.0, 1.0},
                                {3.0, 2.0, -1.0},
                                {1.0, 1e-3, 1e-6},
                                {1.0, 1.0, 0.0},
                                {2.0, 1.0, -0.5},
                                {1.0, 1e-9, 1e-9},
                                {5.0, 5.0, -5.0},
                                {3.0, 1e-4, -1e-5}})
    for (int i = 0; i < 50; ++i)
      for (const double scale : {1.0, 1e12, 1e-12}) {
        const Matrix stretch = {scale * x, 0, 0, 0, scale * y, 0, 0, 0, scale * z}, axes = rotation_matrix(any());
        const Quaternion turn = i == 0 ? Quaternion{0, 0.6, 0.8, 0} : any();  // first a half turn from the identity
        const Quaternion near = i == 0 ? k_identity : any();
        const Matrix a = product(rotation_matrix(turn), product(axes, product(stretch, axes, false), true), false);
        Quaternion q = {};
        sandglass::nearest_rotation(a.data(), near.data(), q.data());
        EXPECT_NEAR(determinant(rotation_matrix(q)), 1.0, 1e-9);
        EXPECT_NEAR((x + y + z - trace_with(q, a) / scale) / x, 0.0, 1e-9) << x << ", " << y << ", " << z;
      }
}

TEST(Rotation, WhatTheMatrixLeavesOpenComesFromTheStart) {
  const double c = std::cos(0.2), s = std::sin(0.2);
  const Quaternion near = {s, 0, 0, c};  // 0.4 rad about x
  Quaternion q = {};
  const Matrix empty = {};
  sandglass::nearest_rotation(empty.data(), near.data(), q.data());
  for (size_t k = 0; k < 4; ++k) EXPECT_EQ(q[k], near[k]) << "a point knows no rotation";
  // A straight body along x that has not turned. The turn about its own axis stays as it was.
  const Matrix line = {2, 0, 0, 0, 0, 0, 0, 0, 0};
  sandglass::nearest_rotation(line.data(), near.data(), q.data());
  for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(q[k], near[k], 1e-12);
  // A flat body is fully determined.
  const Matrix flat = product(rotation_matrix(near), {2, 0, 0, 0, 1, 0, 0, 0, 0}, false);
  sandglass::nearest_rotation(flat.data(), k_identity.data(), q.data());
  EXPECT_NEAR(std::fabs(q[0] * near[0] + q[3] * near[3]), 1.0, 1e-9);
}

TEST(Rotation, OfAMatrixThatIsNotFiniteIsTheStart) {
  const Quaternion near = {0, 0.6, 0, 0.8};
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    const Matrix a = {1, 0, 0, 0, bad, 0, 0, 0, 1};
    Quaternion q = {};
    sandglass::nearest_rotation(a.data(), near.data(), q.data());
    for (size_t k = 0; k < 4; ++k) EXPECT_EQ(q[k], near[k]);
  }
}

}  // namespace
