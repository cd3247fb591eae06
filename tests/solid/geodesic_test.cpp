// Distances along the surface, (3.14) of the dissertation, on surfaces where they are known: a folded sheet, which
// unrolls into a plane; a sphere; the net of a cube; and a plate with a notch, where shortest paths turn around the
// inner corner.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>

#include "models/mesh/generated.h"
#include "runtime/solid/sampling/geodesic.h"
#include "tests/guarded_block.h"
#include "tests/solid/point_checks.h"

namespace sandglass::test {
namespace {

// Distances from one surface point to others, by the library's search.
class Surface {
 public:
  Surface(const host::Mesh& mesh, std::vector<Candidate> targets)
      : mesh_(mesh), view_(mesh_.view()), targets_(std::move(targets)), block_(bytes()) {
    Layout layout;
    layout.base = static_cast<uint8_t*>(block_.data());
    geodesic_ = lay_out_geodesic(&layout, &view_, targets_.size());
    build_geodesic(&geodesic_, targets_.data());
  }
  // Calls visit(from, to, distance) for each of the sources and every target.
  template <class Visit>
  void measure(std::span<const Candidate> sources, double radius, const Visit& visit) {
    for (const Candidate& source : sources) {
      begin_near(&geodesic_);
      for (uint32_t i = 0; i < targets_.size(); ++i) add_near(&geodesic_, i);
      measure_near(&geodesic_, source.position, source.triangle, radius);
      for (size_t i = 0; i < targets_.size(); ++i)
        visit(source.position, targets_[i].position, geodesic_.near.distance[i]);
    }
    EXPECT_TRUE(block_.guards_intact());
  }

 private:
  uint64_t bytes() {
    Layout layout;
    lay_out_geodesic(&layout, &view_, targets_.size());
    return layout.size;
  }
  host::Mesh mesh_;
  sandglass_mesh view_;
  std::vector<Candidate> targets_;
  GuardedBlock block_;
  Geodesic geodesic_;
};

std::vector<Candidate> random_targets(const host::Mesh& mesh, int count, uint64_t seed) {
  const sandglass_mesh surface = mesh.view();
  std::vector<double> running(mesh.triangle_count());
  CandidateStream stream = candidate_stream(surface, running.data(), sum_areas(surface, running.data()), seed);
  std::vector<Candidate> targets;
  for (int i = 0; i < count; ++i) targets.push_back(draw_candidate(&stream));
  return targets;
}

// A sheet 1 m wide (z) that runs 1 m along x, turns up a wall of `gap` and runs back above itself: s along it is a flat
// coordinate.
constexpr double k_gap = 0.02;

host::Mesh folded_sheet(uint32_t steps) {
  host::Mesh sheet;
  std::vector<std::array<double, 2>> profile;
  for (uint32_t i = 0; i <= steps; ++i) profile.push_back({static_cast<double>(i) / steps, 0});
  for (uint32_t i = 0; i <= steps; ++i) profile.push_back({1 - static_cast<double>(i) / steps, k_gap});
  const uint32_t rows = static_cast<uint32_t>(profile.size());
  std::mt19937 jitter(5);  // uneven across the sheet, so that no edges line up
  for (uint32_t i = 0; i < rows; ++i)
    for (uint32_t j = 0; j <= steps; ++j) {
      const double shift = j == 0 || j == steps ? 0 : (static_cast<double>(jitter() % 1000) / 1000 - 0.5) * 0.6 / steps;
      for (double x : {profile[i][0], profile[i][1], static_cast<double>(j) / steps + shift})
        sheet.vertices.push_back(static_cast<float>(x));
    }
  for (uint32_t i = 0; i + 1 < rows; ++i)
    for (uint32_t j = 0; j < steps; ++j) {
      const uint32_t a = i * (steps + 1) + j, b = a + 1, c = a + steps + 1, d = c + 1;
      if ((i + j) % 2 == 0) sheet.indices.insert(sheet.indices.end(), {a, b, c, b, d, c});
      else sheet.indices.insert(sheet.indices.end(), {a, b, d, a, d, c});
    }
  return sheet;
}

std::array<double, 2> unrolled(const float p[3]) {
  const double wall = p[1];
  if (p[1] > k_gap - 1e-9 || (wall > 0.5 * k_gap && p[0] < 1 - 1e-6)) return {1 + k_gap + (1 - p[0]), p[2]};
  return {p[0] + wall, p[2]};
}

TEST(Geodesic, of_a_folded_sheet_is_that_of_the_sheet_rolled_flat) {
  const host::Mesh sheet = folded_sheet(9);
  const std::vector<Candidate> targets = random_targets(sheet, 400, 1);
  int compared = 0;
  Surface(sheet, targets).measure({targets.data(), 40}, 0.8, [&](const float* p, const float* q, double found) {
    const auto from = unrolled(p), to = unrolled(q);
    const double truth = std::hypot(from[0] - to[0], from[1] - to[1]);
    if (truth < 0.8 - 1e-6) {
      ASSERT_NEAR(found, truth, 1e-6);  // float coordinates of sources and targets
      ++compared;
    } else {
      ASSERT_GT(found, 0.8 - 1e-6);
    }
  });
  EXPECT_GT(compared, 2000);
}

TEST(Geodesic, turns_at_an_inner_corner) {
  // An L of three unit squares: from one arm to the other the shortest path bends at the inner corner (1, 1).
  host::Mesh plate;
  for (float z : {0.0f, 1.0f, 2.0f})
    for (float x : {0.0f, 1.0f, 2.0f}) plate.vertices.insert(plate.vertices.end(), {x, 0, z});
  for (uint32_t corner : {0u, 1u, 3u})
    plate.indices.insert(plate.indices.end(), {corner, corner + 3, corner + 1, corner + 1, corner + 3, corner + 4});
  const std::vector<Candidate> targets = random_targets(plate, 600, 5);
  int bent = 0;
  Surface(plate, targets).measure({targets.data(), 30}, 4, [&](const float* p, const float* q, double found) {
    const double ax = p[0], az = p[2], bx = q[0], bz = q[2];
    double truth = std::hypot(ax - bx, az - bz);
    // The straight segment is impossible where it leaves the plate at the corner.
    const bool across = (ax > 1 && bz > 1) || (bx > 1 && az > 1);
    const double side = (bx - ax) * (1 - az) - (bz - az) * (1 - ax);
    if (across && (ax > 1 ? side > 0 : side < 0)) {
      truth = std::hypot(ax - 1, az - 1) + std::hypot(bx - 1, bz - 1);
      ++bent;
    }
    ASSERT_NEAR(found, truth, 1e-6);
  });
  EXPECT_GT(bent, 100);
}

// Windows that fork at every edge would multiply without end: of 13 triangles on the same three vertices the search took
// eight seconds.
TEST(Geodesic, ends_where_many_triangles_share_their_edges) {
  constexpr uint32_t k_pages = 64;
  host::Mesh book, heap;
  book.vertices = heap.vertices = {0, 0, 0, 1, 0, 0};
  heap.vertices.insert(heap.vertices.end(), {0.5f, 0.2f, 0});
  for (uint32_t page = 0; page < k_pages; ++page) {
    const float angle = 6.2831853f * static_cast<float>(page) / k_pages;
    book.vertices.insert(book.vertices.end(), {0.5f, 0.2f * std::cos(angle), 0.2f * std::sin(angle)});
    book.indices.insert(book.indices.end(), {0, 1, 2 + page});
    heap.indices.insert(heap.indices.end(), {0, 1, 2});
  }
  const std::vector<Candidate> in_book = random_targets(book, 300, 7), in_heap = random_targets(heap, 300, 7);
  // Two pages unfold into a rhombus, in which every path is straight.
  Surface(book, in_book).measure({in_book.data(), 20}, 3, [&](const float* p, const float* q, double found) {
    const double dy = std::hypot(p[1] - q[1], p[2] - q[2]);
    const double up = std::hypot(p[1], p[2]), down = std::hypot(q[1], q[2]);
    const bool same_page = dy < std::fabs(up - down) + 1e-6;
    ASSERT_NEAR(found, std::hypot(p[0] - q[0], same_page ? up - down : up + down), 1e-6);
  });
  // In the heap a path stays on its sheet or goes over one of three edges: by the best point of it, as the way is convex.
  Surface(heap, in_heap).measure({in_heap.data(), 20}, 3, [&](const float* p, const float* q, double found) {
    constexpr double k_corners[4][2] = {{0, 0}, {1, 0}, {0.5, 0.2}, {0, 0}};
    double over = 1e9;
    for (int edge = 0; edge < 3; ++edge) {
      const double *a = k_corners[edge], *b = k_corners[edge + 1];
      const auto length = [&](double t) {
        const double x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]);
        return std::hypot(p[0] - x, p[1] - y) + std::hypot(q[0] - x, q[1] - y);
      };
      double low = 0, high = 1;
      for (int step = 0; step < 80; ++step) {
        const double left = low + (high - low) / 3, right = high - (high - low) / 3;
        (length(left) < length(right) ? high : low) = length(left) < length(right) ? right : left;
      }
      over = std::min(over, length(low));
    }
    const double straight = std::hypot(p[0] - q[0], p[1] - q[1]);
    ASSERT_LT(std::min(std::fabs(found - straight), std::fabs(found - over)), 1e-6);
  });
}

TEST(Geodesic, sampling_keeps_the_two_sides_of_a_thin_sheet_apart) {
  const host::Mesh sheet = folded_sheet(12);
  const float distance = 0.05f;  // more than twice the gap
  sandglass_sample_desc desc = desc_with_seed(4);
  const Points euclidean = sample_surface(sheet, distance, desc);
  desc.metric = SANDGLASS_METRIC_GEODESIC;
  const Points geodesic = sample_surface(sheet, distance, desc);

  double unrolled_min = 1;
  for (size_t i = 0; i < geodesic.size(); i += 3)
    for (size_t j = 0; j < i; j += 3) {
      const auto a = unrolled(&geodesic[i]), b = unrolled(&geodesic[j]);
      unrolled_min = std::min(unrolled_min, std::hypot(a[0] - b[0], a[1] - b[1]));
    }
  EXPECT_GT(unrolled_min, distance - 1e-6);
  EXPECT_LT(distance_min(geodesic, distance), 0.6 * static_cast<double>(distance));  // across the gap
  EXPECT_GE(distance_min(euclidean, distance), static_cast<double>(distance));
  // Euclidean distance lets each side block most of the other: the geodesic set is that of a sheet twice as large.
  EXPECT_GT(static_cast<double>(geodesic.size()), 1.4 * static_cast<double>(euclidean.size()));

  // Maximal in the unrolled sheet: no random place is further from a sample than l plus the size of a hole between
  // candidates.
  size_t uncovered = 0;
  const std::vector<Candidate> places = random_targets(sheet, 5000, 6);
  for (const Candidate& place : places) {
    const auto p = unrolled(place.position);
    double nearest = 10;
    for (size_t i = 0; i < geodesic.size(); i += 3) {
      const auto q = unrolled(&geodesic[i]);
      nearest = std::min(nearest, std::hypot(p[0] - q[0], p[1] - q[1]));
    }
    ASSERT_LT(nearest, 1.5 * distance);
    uncovered += nearest > distance;
  }
  EXPECT_LT(static_cast<double>(uncovered), 0.02 * static_cast<double>(places.size()));
}

}  // namespace
}  // namespace sandglass::test
