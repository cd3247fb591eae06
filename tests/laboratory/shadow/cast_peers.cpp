#include "tests/laboratory/shadow/cast_peers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/geometry/vec3.h"
#include "models/tracing/embree_scene.h"

namespace sandglass::host {

namespace {

constexpr int k_side = 512;
constexpr double k_exponent = 40;  // as far as 32-bit floats carry it over depths of 0..1
constexpr double k_bias = 2e-3;    // of the map's depth

}  // namespace

struct ShadowMap::Maps {
  Vec3 towards, u, v;        // the light's frame
  double low[3], size[3];    // of u, v and depth along -towards
  double tangent;            // of the light's half angle
  double highest = 0;        // the longest way from the mesh to the floor, along the light
  std::vector<float> depth;  // of the mesh, in size[2]; 1: nothing
  // Integral images of exp(c d) and its square, one more row and column. Here d is 1 less the way to the floor, so that the
  // floor, which must be in such a map, never shades itself.
  std::vector<double> first, second;

  std::array<double, 3> place(double x, double z) const {
    const Vec3 p{x, 0, z};
    return {(dot(p, u) - low[0]) / size[0], (dot(p, v) - low[1]) / size[1], (-dot(p, towards) - low[2]) / size[2]};
  }
  float at(double a, double b) const {
    const int i = static_cast<int>(std::floor(a * k_side)), j = static_cast<int>(std::floor(b * k_side));
    if (i < 0 || j < 0 || i >= k_side || j >= k_side) return 1;
    return depth[static_cast<size_t>(j * k_side + i)];
  }
  // Means of exp(c d) and its square over a box of the map.
  std::array<double, 2> means(double a, double b, double half_a, double half_b) const {
    const auto bound = [](double t) { return std::clamp(static_cast<int>(std::lround(t * k_side)), 0, k_side); };
    const int i0 = bound(a - half_a), j0 = bound(b - half_b);
    const int i1 = std::min(k_side, std::max(i0 + 1, bound(a + half_a))),
              j1 = std::min(k_side, std::max(j0 + 1, bound(b + half_b)));
    const auto sum = [&](const std::vector<double>& m) {
      const auto of = [&](int i, int j) { return m[static_cast<size_t>(j * (k_side + 1) + i)]; };
      return (of(i1, j1) - of(i0, j1) - of(i1, j0) + of(i0, j0)) / std::max(1, (i1 - i0) * (j1 - j0));
    };
    return {sum(first), sum(second)};
  }
  static double chebyshev(const std::array<double, 2>& m) {
    const double t = std::exp(-k_exponent * k_bias);
    if (t <= m[0]) return 1;
    const double variance = std::max(m[1] - m[0] * m[0], 1e-12);
    return variance / (variance + (t - m[0]) * (t - m[0]));
  }
};

ShadowMap::ShadowMap(const Mesh& mesh, const ShadowRectangle& rectangle, const Direction& light, double half_angle)
    : maps_(std::make_unique<Maps>()) {
  Maps& m = *maps_;
  m.towards = normalised(Vec3{light[0], light[1], light[2]});
  m.u = normalised(cross(m.towards, std::fabs(m.towards.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
  m.v = cross(m.towards, m.u);
  m.tangent = std::tan(half_angle);
  double high[3] = {-1e9, -1e9, -1e9};
  for (double& x : m.low) x = 1e9;
  const auto extend = [&](Vec3 p) {
    const double c[3] = {dot(p, m.u), dot(p, m.v), -dot(p, m.towards)};
    for (int a = 0; a < 3; ++a) {
      m.low[a] = std::min(m.low[a], c[a]);
      high[a] = std::max(high[a], c[a]);
    }
  };
  for (size_t i = 0; i < mesh.vertices.size(); i += 3)
    extend({mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]});
  for (size_t i = 1; i < mesh.vertices.size(); i += 3)
    m.highest = std::max(m.highest, static_cast<double>(mesh.vertices[i]) / std::max(m.towards.y, 0.05));
  for (const double x : {rectangle.low_x, rectangle.high_x})
    for (const double z : {rectangle.low_z, rectangle.high_z}) extend({x, 0, z});
  for (int a = 0; a < 3; ++a) {
    const double margin = 0.01 * (high[a] - m.low[a]);
    m.low[a] -= margin;
    m.size[a] = high[a] + margin - m.low[a];
  }
  const EmbreeScene scene = EmbreeScene::triangles(mesh.vertices, mesh.indices);
  m.depth.resize(k_side * k_side);
  m.first.assign((k_side + 1) * (k_side + 1), 0);
  m.second = m.first;
  for (int j = 0; j < k_side; ++j)
    for (int i = 0; i < k_side; ++i) {
      const double a = m.low[0] + (i + 0.5) / k_side * m.size[0], b = m.low[1] + (j + 0.5) / k_side * m.size[1];
      const EmbreeHit hit = scene.closest(m.u * a + m.v * b - m.towards * m.low[2], m.towards * -1.0, 1.1 * m.size[2]);
      const double to_floor = (m.u * a + m.v * b - m.towards * m.low[2]).y / m.towards.y;
      const double d = static_cast<double>(hit.distance);
      const double e = hit.found ? std::exp(-k_exponent * std::max(0.0, to_floor - d) / m.size[2]) : 1.0;
      m.depth[static_cast<size_t>(j * k_side + i)] = hit.found ? static_cast<float>(d / m.size[2]) : 1.0f;
      const size_t at = static_cast<size_t>((j + 1) * (k_side + 1) + i + 1), up = at - (k_side + 1);
      m.first[at] = e + m.first[at - 1] + m.first[up] - m.first[up - 1];
      m.second[at] = e * e + m.second[at - 1] + m.second[up] - m.second[up - 1];
    }
}

ShadowMap::~ShadowMap() = default;

double ShadowMap::percentage_closer(double x, double z, uint32_t taps) const {
  const Maps& m = *maps_;
  const std::array<double, 3> p = m.place(x, z);
  const double receiver = p[2] - k_bias;
  const auto over_disk = [&](double radius, const auto& visit) {
    for (uint32_t k = 0; k < taps; ++k) {
      const double r = radius * std::sqrt((k + 0.5) / taps), f = 2.399963229728653 * k;
      visit(static_cast<double>(m.at(p[0] + r * std::cos(f) / m.size[0], p[1] + r * std::sin(f) / m.size[1])));
    }
  };
  double sum = 0, lit = 0;
  uint32_t blockers = 0;
  over_disk(m.tangent * p[2] * m.size[2], [&](double d) {
    if (d < receiver) {
      sum += d;
      ++blockers;
    }
  });
  if (blockers == 0) return 1;
  over_disk(m.tangent * (p[2] - sum / blockers) * m.size[2], [&](double d) { lit += d < receiver ? 0 : 1; });
  return lit / taps;
}

double ShadowMap::exponential_variance(double x, double z) const {
  const Maps& m = *maps_;
  const std::array<double, 3> p = m.place(x, z);
  const double search = m.tangent * m.highest * 0.886;  // half a square as large as the disk
  const auto all = m.means(p[0], p[1], search / m.size[0], search / m.size[1]);
  const double lit = Maps::chebyshev(all);
  if (lit >= 1) return 1;
  // What the bound says is lit counts as the floor; the rest is the blockers'.
  const double blocker = (all[0] - lit) / std::max(1 - lit, 1e-6);
  const double gap = std::clamp(blocker > 0 ? -std::log(blocker) / k_exponent : 1.0, 0.0, m.highest / m.size[2]);
  const double penumbra = std::max(m.tangent * gap * m.size[2] * 0.886, 1e-6);
  return Maps::chebyshev(m.means(p[0], p[1], penumbra / m.size[0], penumbra / m.size[1]));
}

double ellipse(const ShadowBox& box, const Direction& light, double half_angle, double x, double z) {
  const double flat = std::hypot(light[0], light[2]), slope = flat / std::max(light[1], 0.05), height = box.height;
  const double ax = flat > 0 ? light[0] / flat : 1, az = flat > 0 ? light[2] / flat : 0;
  const double along = 0.5 * (box.half_x + box.half_z) + 0.5 * slope * height, across = 0.5 * (box.half_x + box.half_z);
  const double dx = x + 0.5 * slope * height * ax, dz = z + 0.5 * slope * height * az;
  const double p = (dx * ax + dz * az) / along, q = (-dx * az + dz * ax) / across, r = std::hypot(p, q);
  const double blur =
      std::max(0.02, std::tan(half_angle) * 0.5 * height * std::hypot(1.0, slope) / std::sqrt(along * across));
  return std::clamp(0.5 + 0.5 * (r - 1) / blur, 0.0, 1.0);
}

}  // namespace sandglass::host
