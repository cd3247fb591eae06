// Fields and samples of any mesh: refused by a sentence, or every number is finite and every point where it must be.
#include <algorithm>
#include <cmath>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"

namespace {

using sandglass::fuzz::expect;

constexpr uint32_t k_corners = 8, k_triangles = 12, k_points_max = 2000;
constexpr double k_rounding = 6.1e-5;      // of a coordinate at the limit, metres
constexpr uint64_t k_bytes_max = 1 << 20;  // larger ones are made by apps, not thousands of times a second

// A box and what is asked of it, as plain bytes that the fuzzer changes.
struct Request {
  float vertices[3 * k_corners] = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1};
  uint32_t indices[3 * k_triangles] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  uint32_t vertex_count = k_corners, triangle_count = k_triangles;
  float low[3] = {-1.5f, -1.5f, -1.5f}, high[3] = {1.5f, 1.5f, 1.5f}, point[3] = {0.1f, 0.2f, 0.3f};
  float spacing = 0.4f, band = 0.8f, distance = 0.5f, radius = 1.0f, theta[2] = {0.3f, 2.0f};
  int32_t solid = SANDGLASS_SOLID_INSIDE, rule = SANDGLASS_INSIDE_PARITY, metric = SANDGLASS_METRIC_EUCLIDEAN;
  uint32_t tries = 30, count = 20;
  uint64_t seed = 1;
};

struct alignas(SANDGLASS_BLOCK_ALIGNMENT) Block {
  std::byte bytes[k_bytes_max];
};
Block g_prepared, g_field, g_scratch;

struct Outcome {
  const char* reason = nullptr;
  bool operator()(int32_t status) const {
    expect((status == SANDGLASS_OK) == (reason == nullptr));
    return status == SANDGLASS_OK;
  }
};

void expect_finite(const float* values, size_t count) {
  for (size_t i = 0; i < count; ++i) expect(std::isfinite(values[i]));
}

template <class Desc>
void set_box(const Request& r, Desc* desc) {
  std::copy(r.low, r.low + 3, desc->bounds_min);
  std::copy(r.high, r.high + 3, desc->bounds_max);
}

void try_field(const Request& r, const sandglass_mesh& mesh, sandglass_mesh_inside* inside) {
  Outcome ok;
  uint64_t bytes = 0;
  sandglass_field_desc desc = sandglass::field_desc();
  set_box(r, &desc);
  desc.spacing = r.spacing;
  desc.band = r.band;
  desc.solid = r.solid;
  desc.mesh = &mesh;
  desc.inside = sandglass_mesh_inside_test;
  desc.inside_user = inside;
  if (!ok(sandglass_field_bytes(&desc, &bytes, &ok.reason)) || bytes > k_bytes_max) return;
  // The time grows with band^3 / spacing^3.
  if (r.band > 20 * r.spacing) return;
  sandglass_field* field = nullptr;
  if (!ok(sandglass_field_create(&desc, &g_field, bytes, &field, &ok.reason))) return;
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

// How many points there are; 0: it was refused, or is too large. With the memory and the capacity that the library itself
// named, a run does not fail.
uint32_t try_points(const sandglass_sample_desc& desc, float* points) {
  Outcome ok;
  uint32_t capacity = 0, count = 0;
  uint64_t bytes = 0;
  if (!ok(sandglass_sample_capacity(&desc, &capacity, &ok.reason)) || capacity > k_points_max) return 0;
  expect(ok(sandglass_sample_bytes(&desc, capacity, &bytes, &ok.reason)));
  if (bytes > k_bytes_max) return 0;
  expect(ok(sandglass_sample_points(&desc, &g_scratch, bytes, points, capacity, &count, &ok.reason)));
  expect(count <= capacity);
  expect_finite(points, 3 * count);
  return count;
}

void try_surface(const sandglass_sample_desc& desc, float* points) {
  const uint32_t count = try_points(desc, points);
  if (desc.metric != SANDGLASS_METRIC_EUCLIDEAN) return;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t j = 0; j < i; ++j) {
      const double dx = double{points[3 * i]} - double{points[3 * j]},
                   dy = double{points[3 * i + 1]} - double{points[3 * j + 1]},
                   dz = double{points[3 * i + 2]} - double{points[3 * j + 2]};
      expect(std::sqrt(dx * dx + dy * dy + dz * dz) >= 0.999 * double{desc.distance} - 4 * k_rounding);
    }
}

void try_volume(sandglass_sample_desc desc, float* points) {
  for (const sandglass_sample_method method : {SANDGLASS_SAMPLE_VOLUME, SANDGLASS_SAMPLE_LATTICE}) {
    desc.method = method;
    const uint32_t count = try_points(desc, points);
    for (uint32_t i = 0; i < count; ++i) expect(sandglass_mesh_inside_test(desc.inside_user, points + 3 * i) == 1);
  }
}

void try_shapes(const Request& r, float* points) {
  Outcome ok;
  const uint32_t count = r.count > k_points_max ? 0 : r.count;
  for (int shape = 0; shape < 3; ++shape) {
    const int32_t status = shape == 0 ? sandglass_sample_disk(r.radius, points, count, &ok.reason)
                           : shape == 1
                               ? sandglass_sample_sphere(r.radius, points, count, &ok.reason)
                               : sandglass_sample_ring(r.radius, r.theta[0], r.theta[1], points, count, &ok.reason);
    if (ok(status)) expect_finite(points, 3 * count);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Request base;
  static std::vector<float> points(3 * k_points_max);
  Request r = sandglass::fuzz::edited(base, data, size);
  r.vertex_count %= k_corners + 1;
  r.triangle_count %= k_triangles + 1;
  const sandglass_mesh mesh = {r.vertices, r.vertex_count, r.indices, r.triangle_count};
  try_shapes(r, points.data());

  Outcome ok;
  double area = 0, winding = 0;
  float low[3], high[3];
  const bool usable = ok(sandglass_mesh_bounds(&mesh, low, high, &ok.reason));
  expect(ok(sandglass_mesh_area(&mesh, &area, &ok.reason)) == usable && std::isfinite(area));
  if (!usable) return 0;
  if (ok(sandglass_mesh_winding_number(&mesh, r.point, &winding, &ok.reason))) expect(std::isfinite(winding));
  sandglass_sample_desc desc = sandglass::sample_desc();
  set_box(r, &desc);
  desc.distance = r.distance;
  desc.seed = r.seed;
  desc.tries = r.tries;
  desc.metric = r.metric;
  desc.mesh = &mesh;
  if (r.tries <= 100) try_surface(desc, points.data());
  uint64_t need = 0;
  if (!ok(sandglass_mesh_inside_bytes(&mesh, r.rule, &need, &ok.reason)) || need > k_bytes_max) return 0;
  sandglass_mesh_inside* inside = nullptr;
  if (!ok(sandglass_mesh_inside_create(&mesh, r.rule, &g_prepared, need, &inside, &ok.reason))) return 0;
  (void)sandglass_mesh_inside_test(inside, r.point);
  try_field(r, mesh, inside);
  desc.inside = sandglass_mesh_inside_test;
  desc.inside_user = inside;
  if (r.tries <= 100) try_volume(desc, points.data());
  return 0;
}
