// Alg. 1 of the dissertation: least distance, maximality over the same candidates, points on the surface, parts that
// growth cannot reach.
#include <gtest/gtest.h>

#include <cmath>

#include "models/mesh/generated.h"
#include "runtime/solid/sampling/candidates.h"
#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

// The candidates that a run with this seed draws, by the library's own random numbers.
Points candidates_of(const host::Mesh& mesh, float distance, uint64_t seed) {
  const sandglass_mesh surface = mesh.view();
  std::vector<double> running(mesh.triangle_count());
  const double area = sum_areas(surface, running.data());
  CandidateStream stream = candidate_stream(surface, running.data(), area, seed);
  Points points;
  for (uint32_t i = 0; i < static_cast<uint32_t>(candidate_count(area, distance, 30)); ++i) {
    const Candidate candidate = draw_candidate(&stream);
    points.insert(points.end(), candidate.position, candidate.position + 3);
  }
  return points;
}

void expect_maximal(const Points& samples, const Points& places, double distance) {
  const PointLookup lookup(samples, distance);
  size_t uncovered = 0;
  for (size_t i = 0; i < places.size(); i += 3) uncovered += !(lookup.nearest(&places[i]) < distance);
  EXPECT_EQ(uncovered, 0u) << "of " << places.size() / 3;
}

TEST(Surface, keeps_the_least_distance_and_is_maximal) {
  const host::Mesh mesh = host::make_torus(0.1f, 0.04f, 60, 30);
  const float distance = 0.006f;
  for (uint64_t seed : {1ull, 2ull, 12345678901234567ull}) {
    const Points samples = sample_surface(mesh, distance, desc_with_seed(seed));
    EXPECT_GE(distance_min(samples, distance), static_cast<double>(distance));
    expect_maximal(samples, candidates_of(mesh, distance, seed), distance);
  }
}

TEST(Surface, reaches_parts_further_apart_than_two_distances) {
  const float leg[3] = {0.02f, 0.3f, 0.02f};
  const host::Mesh box = host::make_box(leg);
  host::Mesh legs;
  for (const float aside : {-0.5f, 0.5f}) {
    for (const uint32_t i : box.indices) legs.indices.push_back(i + legs.vertex_count());
    for (size_t i = 0; i < box.vertices.size(); ++i)
      legs.vertices.push_back(box.vertices[i] + (i % 3 == 0 ? aside : 0.0f));
  }
  const float distance = 0.01f;
  const Points samples = sample_surface(legs, distance, desc_with_seed(3));
  size_t left = 0, right = 0;
  for (size_t i = 0; i < samples.size(); i += 3) (samples[i] < 0 ? left : right) += 1;
  // Two equal boxes: their counts differ by chance only, by a few per cent of about 170.
  EXPECT_NEAR(static_cast<double>(left) / static_cast<double>(right), 1, 0.2);
  EXPECT_GE(distance_min(samples, distance), static_cast<double>(distance));
  expect_maximal(samples, candidates_of(legs, distance, 3), distance);
}

TEST(Surface, lies_on_the_surface) {
  const float size[3] = {0.2f, 0.3f, 0.4f};
  const Points samples = sample_surface(host::make_box(size), 0.02f, desc_with_seed(1));
  ASSERT_GT(samples.size(), 300u);
  for (size_t i = 0; i < samples.size(); i += 3) {
    double off = 1;
    for (size_t k = 0; k < 3; ++k) {
      const double beyond = std::fabs(samples[i + k]) - 0.5 * size[k];
      ASSERT_LT(beyond, 1e-7);
      off = std::min(off, std::fabs(beyond));
    }
    ASSERT_LT(off, 1e-7);
  }
}

TEST(Surface, fills_the_plane_as_densely_as_random_packing_does) {
  // Maximal Poisson-disk sets have about 0.7 points per distance^2: random sequential packing of disks of diameter l
  // jams at a coverage of 0.547, which is 0.547/(pi/4) = 0.697 (Feder 1980). Finite candidates give a little less, the
  // rim a little more.
  const float distance = 0.02f;
  host::Mesh square;
  square.vertices = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
  square.indices = {0, 2, 1, 0, 3, 2};
  const Points samples = sample_surface(square, distance, desc_with_seed(1));
  const double density = static_cast<double>(samples.size() / 3) * distance * distance;
  EXPECT_GT(density, 0.62);
  EXPECT_LT(density, 0.75);
}

TEST(Surface, weighs_triangles_by_area) {
  // A square of one large triangle and many small ones: both halves must get equally many candidates.
  host::Mesh square;
  square.vertices = {0, 0, 0, 1, 0, 0, 1, 0, 1};
  square.indices = {0, 1, 2};
  const uint32_t strips = 64;
  for (uint32_t i = 0; i <= strips; ++i) {
    const float t = static_cast<float>(i) / strips;
    square.vertices.insert(square.vertices.end(), {t, 0, t});
  }
  square.vertices.insert(square.vertices.end(), {0, 0, 1});
  for (uint32_t i = 0; i < strips; ++i) square.indices.insert(square.indices.end(), {3 + i, 4 + i, 4 + strips});
  const Points candidates = candidates_of(square, 0.01f, 9);
  double above = 0;
  for (size_t i = 0; i < candidates.size(); i += 3) above += candidates[i + 2] > candidates[i];
  const double n = static_cast<double>(candidates.size() / 3);
  EXPECT_NEAR(above / n, 0.5, 4 * 0.5 / std::sqrt(n));  // four standard deviations
}

TEST(Surface, gives_a_tiny_object_one_sample) {
  const float size[3] = {0.001f, 0.001f, 0.001f};
  EXPECT_EQ(sample_surface(host::make_box(size), 0.1f, desc_with_seed(1)).size(), 3u);
}

}  // namespace
}  // namespace sandglass::test
