// Fields and samples of any mesh: refused by a sentence, or every number is finite and every point where it must be.
#include <cmath>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"

namespace {

using sandglass::fuzz::expect;

constexpr uint32_t k_corners = 8, k_triangles = 12, k_points_most = 2000;
constexpr double k_rounding = 6.1e-5;       // of a coordinate at the limit, metres
constexpr uint64_t k_bytes_most = 1 << 20;  // larger ones are made by apps, not thousands of times a second

// A box and what is asked of it, as plain bytes that the fuzzer changes.
struct Request {
  float vertices[3 * k_corners] = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1};
  uint32_t indices[3 * k_triangles] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  uint32_t vertex_count = k_corners, triangle_count = k_triangles;
  float low[3] = {-1.5f, -1.5f, -1.5f}, high[3] = {1.5f, 1.5f, 1.5f}, point[3] = {0.1f, 0.2f, 0.3f};
  float spacing = 0.4f, band = 0.8f, distance = 0.5f, frequency_max = 3.0f, radius = 1.0f, theta[2] = {0.3f, 2.0f};
  int32_t solid = SANDGLASS_SOLID_INSIDE, rule = SANDGLASS_INSIDE_PARITY, metric = SANDGLASS_METRIC_EUCLIDEAN;
  uint32_t tries = 30, count = 20, bins = 4, directions = 8;
  uint64_t seed = 1;
};

struct alignas(SANDGLASS_BLOCK_ALIGNMENT) Block {
  std::byte bytes[k_bytes_most];
};
Block g_prepared, g_field, g_scratch;

struct Outcome {
  const char* reason = nullptr;
  bool operator()(int32_t status) const {
    expect((status == SANDGLASS_OK) == (reason == nullptr));
    return status == SANDGLASS_OK;
  }
  // With the memory and the capacity that the library itself named, only an option can be wrong.
  bool of_a_run(int32_t status) const {
    expect(status == SANDGLASS_OK || status == SANDGLASS_ERROR_INVALID_ARGUMENT);
    return (*this)(status);
  }
};

void expect_finite(const float* values, size_t count) {
  for (size_t i = 0; i < count; ++i) expect(std::isfinite(values[i]));
}

void try_field(const Request& r, const sandglass_mesh& mesh, sandglass_mesh_inside* inside) {
  Outcome ok;
  uint64_t bytes = 0;
  if (!ok(sandglass_field_bytes(r.low, r.high, r.spacing, &bytes, &ok.reason)) || bytes > k_bytes_most) return;
  // The time grows with band^3 / spacing^3.
  if (r.band > 20 * r.spacing) return;
  sandglass_field* field = nullptr;
  if (!ok(sandglass_field_from_mesh(&mesh, sandglass_mesh_inside_test, inside, r.low, r.high, r.spacing, r.band,
                                    r.solid, &g_field, bytes, &field, &ok.reason)))
    return;
  float low[3], high[3], normal[3];
  expect(sandglass_field_bounds(field, low, high) == r.solid);
  for (int k = 0; k < 3; ++k) expect(low[k] <= r.low[k] && high[k] >= r.high[k] * (r.high[k] < 0 ? 1.001f : 0.999f));
  for (const float scale : {0.0f, 0.3f, 1.0f, 1.7f, 1e3f, 1e30f}) {
    const float point[3] = {scale * r.point[0], scale * r.point[1], scale * r.point[2]};
    const float distance = sandglass_field_distance(field, point, normal);
    if (std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2])) {
      expect(!std::isnan(distance));
      expect_finite(normal, 3);
    }
  }
}

void try_surface(const Request& r, const sandglass_mesh& mesh, const sandglass_sample_options& options, float* points) {
  Outcome ok;
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  if (!ok(sandglass_sample_surface_capacity(&mesh, r.distance, &options, &capacity, &ok.reason))) return;
  if (capacity > k_points_most) return;
  if (!ok(sandglass_sample_surface_bytes(&mesh, r.distance, &options, capacity, &bytes, &ok.reason))) return;
  if (bytes > k_bytes_most) return;
  expect(ok(
      sandglass_sample_surface(&mesh, r.distance, &options, &g_scratch, bytes, points, capacity, &count, &ok.reason)));
  expect(count <= capacity);
  expect_finite(points, 3 * count);
  if (r.metric != SANDGLASS_METRIC_EUCLIDEAN) return;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = 0; j < i; ++j) {
      const double dx = double{points[3 * i]} - double{points[3 * j]},
                   dy = double{points[3 * i + 1]} - double{points[3 * j + 1]},
                   dz = double{points[3 * i + 2]} - double{points[3 * j + 2]};
      expect(std::sqrt(dx * dx + dy * dy + dz * dz) >= 0.999 * double{r.distance} - 4 * k_rounding);
    }
}

void try_volume(const Request& r, sandglass_mesh_inside* inside, const sandglass_sample_options& options,
                float* points) {
  Outcome ok;
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  if (ok(sandglass_sample_volume_capacity(r.low, r.high, r.distance, &capacity, &ok.reason)) &&
      capacity <= k_points_most &&
      ok(sandglass_sample_volume_bytes(r.low, r.high, r.distance, capacity, &bytes, &ok.reason)) &&
      bytes <= k_bytes_most) {
    (void)ok.of_a_run(sandglass_sample_volume(r.low, r.high, r.distance, sandglass_mesh_inside_test, inside, &options,
                                              &g_scratch, bytes, points, capacity, &count, &ok.reason));
    for (uint32_t i = 0; i < count; ++i) expect(sandglass_mesh_inside_test(inside, points + 3 * i) == 1);
  }
  if (ok(sandglass_sample_lattice_capacity(r.low, r.high, r.distance, &capacity, &ok.reason)) &&
      capacity <= k_points_most && ok(sandglass_sample_lattice_bytes(r.low, r.high, r.distance, &bytes, &ok.reason)) &&
      bytes <= k_bytes_most) {
    (void)ok.of_a_run(sandglass_sample_lattice(r.low, r.high, r.distance, sandglass_mesh_inside_test, inside, &options,
                                               &g_scratch, bytes, points, capacity, &count, &ok.reason));
    for (uint32_t i = 0; i < count; ++i) expect(sandglass_mesh_inside_test(inside, points + 3 * i) == 1);
  }
}

void try_shapes(const Request& r, float* points) {
  Outcome ok;
  const uint32_t count = r.count > k_points_most ? 0 : r.count;
  for (int shape = 0; shape < 3; ++shape) {
    const int32_t status = shape == 0 ? sandglass_sample_disk(r.radius, points, count, &ok.reason)
                           : shape == 1
                               ? sandglass_sample_sphere(r.radius, points, count, &ok.reason)
                               : sandglass_sample_ring(r.radius, r.theta[0], r.theta[1], points, count, &ok.reason);
    if (!ok(status)) continue;
    expect_finite(points, 3 * count);
    if (r.bins > 64 || r.directions > 64) continue;
    double power[64];
    if (ok(sandglass_sample_spectrum(points, count, r.frequency_max, r.bins, r.directions, shape == 0, power,
                                     &ok.reason)))
      for (uint32_t b = 0; b < r.bins; ++b) expect(power[b] >= 0.0 && power[b] <= 1.001 * count);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Request base;
  static std::vector<float> points(3 * k_points_most);
  Request r = sandglass::fuzz::edited(base, data, size);
  r.vertex_count %= k_corners + 1, r.triangle_count %= k_triangles + 1;
  const sandglass_mesh mesh = {r.vertices, r.vertex_count, r.indices, r.triangle_count};
  try_shapes(r, points.data());

  Outcome ok;
  double area = 0, winding = 0;
  float low[3], high[3];
  const bool usable = ok(sandglass_mesh_bounds(&mesh, low, high, &ok.reason));
  expect(ok(sandglass_mesh_area(&mesh, &area, &ok.reason)) == usable && std::isfinite(area));
  if (!usable) return 0;
  if (ok(sandglass_mesh_winding_number(&mesh, r.point, &winding, &ok.reason))) expect(std::isfinite(winding));
  sandglass_sample_options options;
  sandglass_sample_options_default(&options);
  options.seed = r.seed, options.tries = r.tries, options.metric = r.metric;
  if (r.tries <= 100) try_surface(r, mesh, options, points.data());
  uint64_t need = 0;
  if (!ok(sandglass_mesh_inside_bytes(&mesh, r.rule, &need, &ok.reason)) || need > k_bytes_most) return 0;
  sandglass_mesh_inside* inside = nullptr;
  if (!ok(sandglass_mesh_inside_create(&mesh, r.rule, &g_prepared, need, &inside, &ok.reason))) return 0;
  (void)sandglass_mesh_inside_test(inside, r.point);
  try_field(r, mesh, inside);
  if (r.tries <= 100) try_volume(r, inside, options, points.data());
  return 0;
}
