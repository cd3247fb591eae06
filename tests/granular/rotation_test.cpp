// If a matrix does not determine its nearest rotation, the start decides. For other matrices
// tests/laboratory/verify_test.cpp asserts that the result is the best rotation, on matrices of known factors.
#include "runtime/granular/rotation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

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

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c = {};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return c;
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
  const Matrix flat = product(rotation_matrix(near), {2, 0, 0, 0, 1, 0, 0, 0, 0});
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
