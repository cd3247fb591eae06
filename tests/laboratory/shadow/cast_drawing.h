// A cast of a mesh as it is drawn, and how far that is from rays.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "models/baking/truth.h"
#include "models/mesh/mesh.h"
#include "models/work/thread_pool.h"
#include "sandglass/sandglass.hpp"

namespace sandglass::host {

constexpr double k_degree = std::numbers::pi / 180;

// A plane's rectangle with what is left of the light in each texel; nothing is hidden beyond it.
struct Drawn {
  ShadowRectangle rectangle;
  uint32_t texels = 0;
  std::vector<float> left;
  double open = 1;

  double area() const {
    return (rectangle.high_x - rectangle.low_x) * (rectangle.high_z - rectangle.low_z) / texels / texels;
  }
  double at(double x, double z) const {
    const double u = (x - rectangle.low_x) / (rectangle.high_x - rectangle.low_x) * texels - 0.5;
    const double v = (z - rectangle.low_z) / (rectangle.high_z - rectangle.low_z) * texels - 0.5;
    const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v)), n = static_cast<int>(texels);
    const auto of = [&](int a, int b) {
      return a < 0 || b < 0 || a >= n || b >= n ? 1.0 : static_cast<double>(left[static_cast<size_t>(b * n + a)]);
    };
    const double p = u - i, q = v - j;
    return (of(i, j) * (1 - p) + of(i + 1, j) * p) * (1 - q) + (of(i, j + 1) * (1 - p) + of(i + 1, j + 1) * p) * q;
  }
  std::array<double, 2> place(size_t i) const {
    return {rectangle.low_x + (static_cast<double>(i % texels) + 0.5) / texels * (rectangle.high_x - rectangle.low_x),
            rectangle.low_z + (static_cast<double>(i / texels) + 0.5) / texels * (rectangle.high_z - rectangle.low_z)};
  }
};

struct Light {
  Direction direction;
  double half;  // radians
};

inline Direction direction_at(double elevation, double azimuth) {
  return {std::cos(elevation) * std::cos(azimuth), std::sin(elevation), std::cos(elevation) * std::sin(azimuth)};
}

// What is drawn, and how.
struct CastChoice {
  uint32_t texels = 128, directions = 64;
  bool closed = true;
  uint32_t version = 0;                                                // of the mesh
  const Mesh* real = nullptr;                                          // stands in the camera's image
  std::optional<ShadowRectangle> limits = {};                          // of the plane
  std::optional<std::array<float, SANDGLASS_LIGHT_CELLS>> cells = {};  // draws the ambient shadow instead
};

// On the floor y = 0 of the mesh's frame. `kept`: a cast that has drawn the frame before.
Drawn cast_of(const Mesh& mesh, const Light& light, const CastChoice& choice, Cast* kept = nullptr);

// Two sets of rays on the texels of a drawing, so that their noise cancels.
struct Truth {
  std::vector<float> a, b;
};

Truth truth_of(const Mesh& mesh, const Light& light, const Drawn& drawn, uint64_t stream, ThreadPool& pool);

// Root mean square over the rectangle of `area` that the shadow was measured in by those who set the bar.
double error_of(const std::function<double(size_t)>& left, const Truth& truth, double texel, double area);

// The shadow's own rectangle: the box, and what the light's cone throws of it, up to four heights long.
ShadowRectangle fitted(const ShadowBox& box, const Light& light);
inline double area_of(const ShadowRectangle& r) { return (r.high_x - r.low_x) * (r.high_z - r.low_z); }

inline Direction turned(const Direction& d, double degrees) {
  const double c = std::cos(degrees * k_degree), s = std::sin(degrees * k_degree);
  return {c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]};
}

struct Sum {
  double sum = 0, worst = 0;
  uint32_t count = 0;
  void add(double x) {
    sum += x;
    worst = std::max(worst, x);
    ++count;
  }
  double mean() const { return sum / std::max(1u, count); }
};

}  // namespace sandglass::host
