// The nearest rotation against singular values found independently. The best trace is s1 + s2 + sign(det A) s3.
#include "runtime/core/rigid_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
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

// Singular values, largest first: roots of the characteristic cubic of A^T A.
std::array<double, 3> singular_values(const Matrix& a) {
  const Matrix g = product(a, a, true);
  const double mean = (g[0] + g[4] + g[8]) / 3;
  Matrix b = g;
  for (const size_t i : {0u, 4u, 8u}) b[i] -= mean;
  double p = 0;
  for (const double v : b) p += v * v;
  p = std::sqrt(p / 6);
  std::array<double, 3> values = {mean, mean, mean};
  if (p > 0) {
    Matrix c = b;
    for (double& v : c) v /= p;
    const double angle = std::acos(std::clamp(determinant(c) / 2, -1.0, 1.0)) / 3;
    for (size_t k = 0; k < 3; ++k) values[k] = mean + 2 * p * std::cos(angle + 2 * M_PI * static_cast<double>(k) / 3);
  }
  std::sort(values.begin(), values.end(), std::greater<>());
  for (double& v : values) v = std::sqrt(std::max(v, 0.0));
  return values;
}

void expect_best(const Matrix& a, const Quaternion& near, const char* what) {
  Quaternion q = {};
  sandglass::nearest_rotation(a.data(), near.data(), q.data());
  const Matrix r = rotation_matrix(q);
  EXPECT_NEAR(determinant(r), 1.0, 1e-9) << what;
  const std::array<double, 3> s = singular_values(a);
  const double best = s[0] + s[1] + (determinant(a) < 0 ? -s[2] : s[2]);
  const double size = std::max(s[0], 1e-300);
  EXPECT_LE((best - trace_with(q, a)) / size, 1e-6)
      << what << ": what the method reaches, up to the rounding of the cubic; rigid bodies allow 1e-3";
}

TEST(Rotation, IsTheBestOneForRandomMatricesAtAnyScale) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    Matrix a;
    for (double& v : a) v = normal(random);
    Quaternion near;
    double length = 0;
    for (double& v : near) v = normal(random), length += v * v;
    for (double& v : near) v /= std::sqrt(length);
    for (const double scale : {1.0, 1e12, 1e-12}) {
      Matrix scaled = a;
      for (double& v : scaled) v *= scale;
      expect_best(scaled, near, "random");
    }
  }
}

TEST(Rotation, RecoversAHalfTurnFromTheIdentity) {
  for (const Quaternion& turn : {Quaternion{1, 0, 0, 0}, Quaternion{0, 1, 0, 0}, Quaternion{0, 0.6, 0.8, 0}}) {
    const Matrix stretch = {3, 0, 0, 0, 2, 0, 0, 0, 1};
    const Matrix a = product(rotation_matrix(turn), stretch, false);
    Quaternion q = {};
    sandglass::nearest_rotation(a.data(), k_identity.data(), q.data());
    const double same = std::fabs(q[0] * turn[0] + q[1] * turn[1] + q[2] * turn[2] + q[3] * turn[3]);
    EXPECT_NEAR(same, 1.0, 1e-9);
  }
}

TEST(Rotation, AMirroredBodyIsTurnedAndNotMirrored) {
  expect_best({-1, 0, 0, 0, 2, 0, 0, 0, 3}, k_identity, "mirrored");
  expect_best({-1, 0, 0, 0, -1, 0, 0, 0, -1}, k_identity, "inverted");
}

// Turned and stretched by known factors, of which only the smallest may be negative: the best trace is their sum.
TEST(Rotation, IsTheBestOneOfNearlyFlatAndNearlyMirroredMatrices) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto any = [&] {
    Quaternion q = {};
    double length = 0;
    for (double& v : q) v = normal(random), length += v * v;
    for (double& v : q) v /= std::sqrt(length);
    return rotation_matrix(q);
  };
  for (const auto& [x, y, z] : {std::array{1.0, 1e-3, 1e-6},
                                {1.0, 1.0, 0.0},
                                {2.0, 1.0, -0.5},
                                {1.0, 1e-9, 1e-9},
                                {5.0, 5.0, -5.0},
                                {3.0, 1e-4, -1e-5}})
    for (int i = 0; i < 50; ++i) {
      const Matrix stretch = {x, 0, 0, 0, y, 0, 0, 0, z}, axes = any();
      const Matrix a = product(any(), product(axes, product(stretch, axes, false), true), false);
      Quaternion q = {};
      sandglass::nearest_rotation(a.data(), k_identity.data(), q.data());
      EXPECT_NEAR((x + y + z - trace_with(q, a)) / x, 0.0, 1e-9) << x << ", " << y << ", " << z;
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
