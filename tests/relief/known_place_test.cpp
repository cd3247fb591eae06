// What an app knows of a place beside depth images: meshes, and the outline of a plane. Heights against those of the
// triangles themselves, in double; who is within an outline against the angle that it goes about a cell.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/relief/depth_of_box.h"

namespace sandglass::tests {
namespace {

using Point = std::array<double, 3>;
constexpr double k_unit = 0.00025, k_cell = 0.01, k_flat = 0.008;  // metres
constexpr uint32_t k_cells = 128;
// Metres: a height is rounded to its unit, after some operations in single precision.
constexpr double k_rounded = 0.5 * k_unit + 1e-5;

struct Triangles {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  sandglass_cast_mesh mesh = cast_mesh();

  void triangle(const Point& a, const Point& b, const Point& c) {
    for (const Point* p : {&a, &b, &c}) {
      indices.push_back(static_cast<uint32_t>(indices.size()));
      for (const double x : *p) positions.push_back(static_cast<float>(x));
    }
  }
  void square(const Point& a, const Point& b, const Point& c, const Point& d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }
  void box(const Point& low, const Point& high) {
    for (const double y : {low[1], high[1]})
      square({low[0], y, low[2]}, {high[0], y, low[2]}, {high[0], y, high[2]}, {low[0], y, high[2]});
    for (const double x : {low[0], high[0]})
      square({x, low[1], low[2]}, {x, high[1], low[2]}, {x, high[1], high[2]}, {x, low[1], high[2]});
    for (const double z : {low[2], high[2]})
      square({low[0], low[1], z}, {high[0], low[1], z}, {high[0], high[1], z}, {low[0], high[1], z});
  }
  const sandglass_cast_mesh* told() {
    mesh.positions = positions.data();
    mesh.indices = indices.data();
    mesh.vertex_count = static_cast<uint32_t>(positions.size() / 3);
    mesh.triangle_count = static_cast<uint32_t>(indices.size() / 3);
    return &mesh;
  }
  Point corner(size_t i) const { return {positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}; }
};

double middle(uint32_t i) { return k_cell * (i + 0.5 - 0.5 * k_cells); }

Relief shown(const sandglass_cast_mesh* mesh, float ceiling = 0.5f) {
  sandglass_relief_desc desc = relief_desc();
  desc.ceiling = ceiling;
  Relief relief = made(desc);
  EXPECT_TRUE(relief.set_meshes(mesh, 1));
  relief.run();
  return relief;
}

std::vector<float> all(const Relief& relief) {
  const sandglass_heights h = relief.heights();
  return {h.heights, h.heights + h.cells[0] * h.cells[1]};
}

// Cells whose height is not this one's.
template <class Height>
uint32_t wrong(const Relief& relief, const Height& height) {
  const std::vector<float> heights = all(relief);
  uint32_t count = 0;
  for (uint32_t i = 0; i < heights.size(); ++i) {
    const double truth = height(middle(i % k_cells), middle(i / k_cells));
    count += !(std::fabs(heights[i] - truth) <= k_rounded) ? 1 : 0;
  }
  return count;
}

// 5 cm high.
double on_box(double x, double z) { return std::fabs(x - 0.021) < 0.1 && std::fabs(z + 0.033) < 0.0715 ? 0.05 : 0; }
Triangles the_box() {
  Triangles t;
  t.box({0.021 - 0.1, 0, -0.033 - 0.0715}, {0.021 + 0.1, 0.05, -0.033 + 0.0715});
  return t;
}

TEST(KnownPlace, ABoxIsAsHighAsItIs) {
  Triangles t = the_box();
  const Relief relief = shown(t.told());
  EXPECT_EQ(wrong(relief, on_box), 0u);
  EXPECT_GT(wrong(made(), on_box), 250u);  // the control: no mesh
  EXPECT_EQ(relief.heights().version, 1u);
  const sandglass_heights h = relief.heights();
  for (uint32_t i = 0; i < 2; ++i) {
    const double half = i == 0 ? 0.1 : 0.0715, at = i == 0 ? 0.021 : -0.033;
    EXPECT_EQ(h.low[i], std::ceil((at - half) / k_cell + 0.5 * k_cells - 0.5));
    EXPECT_EQ(h.high[i], std::ceil((at + half) / k_cell + 0.5 * k_cells - 0.5));
  }
}

TEST(KnownPlace, IsInTheFrameOfItsPlane) {
  Triangles t = the_box();
  const float axis[3] = {0.3f, 0.8f, -0.4f}, position[3] = {3, -2, 5};
  std::array<float, 4> rotation;
  sandglass_rotation_about(axis, 1.2f, rotation.data());
  // The mesh's matrix is the plane's pose, so it stands on it.
  for (int column = 0; column < 3; ++column) {
    const float *q = rotation.data(), e[3] = {column == 0 ? 1.0f : 0, column == 1 ? 1.0f : 0, column == 2 ? 1.0f : 0};
    const float w = q[3], cross[3] = {q[1] * e[2] - q[2] * e[1] + w * e[0], q[2] * e[0] - q[0] * e[2] + w * e[1],
                                      q[0] * e[1] - q[1] * e[0] + w * e[2]};
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      t.mesh.world_from_mesh[4 * column + k] = e[k] + 2 * (q[i] * cross[j] - q[j] * cross[i]);
    }
  }
  for (int k = 0; k < 3; ++k) t.mesh.world_from_mesh[12 + k] = position[k];
  Relief relief = made();
  EXPECT_TRUE(relief.set_plane(position, rotation));
  EXPECT_TRUE(relief.set_meshes(t.told(), 1));
  relief.run();
  EXPECT_EQ(wrong(relief, on_box), 0u);
  // By less than 2 mm a plane moves without another height; by more it does not.
  const float near[3] = {position[0], position[1] - 0.0015f, position[2]},
              far[3] = {position[0], position[1] - 0.02f, position[2]};
  EXPECT_TRUE(relief.set_plane(near, rotation));
  EXPECT_EQ(relief.run(), 0u);
  EXPECT_TRUE(relief.set_plane(far, rotation));
  EXPECT_GT(relief.run(), 0u);
  EXPECT_GT(wrong(relief, on_box), 250u);
}

TEST(KnownPlace, WhatIsAboveTheCeilingIsNoGround) {
  Triangles t;
  t.box({-0.2, 0.3, -0.2}, {0.2, 0.32, 0.2});  // a table's top, above
  t.box({-0.05, 0, -0.05}, {0.05, 0.04, 0.05});
  const auto low = [](double x, double z) { return std::fabs(x) < 0.05 && std::fabs(z) < 0.05 ? 0.04 : 0; };
  EXPECT_EQ(wrong(shown(t.told(), 0.25f), low), 0u);
  const auto high = [](double x, double z) { return std::fabs(x) < 0.2 && std::fabs(z) < 0.2 ? 0.32 : 0; };
  EXPECT_EQ(wrong(shown(t.told()), high), 0u);
}

// The highest triangle over a place, or no height; `doubtful` where it is so near an edge that either is right.
double highest(const Triangles& t, double ceiling, double x, double z, bool* doubtful) {
  double best = -1;
  for (size_t i = 0; i < t.indices.size(); i += 3) {
    const Point a = t.corner(i), b = t.corner(i + 1), c = t.corner(i + 2);
    const double area = (b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0]);
    if (std::fabs(area) < 1.1e-3 * k_cell * k_cell) continue;
    double share[3], nearest = 1e9;
    for (int k = 0; k < 3; ++k) {
      const Point &p = k == 0 ? b : (k == 1 ? c : a), &q = k == 0 ? c : (k == 1 ? a : b);
      const double side = ((q[0] - p[0]) * (z - p[2]) - (q[2] - p[2]) * (x - p[0]));
      share[k] = side / area;
      nearest = std::min(nearest, (area > 0 ? side : -side) / std::hypot(q[0] - p[0], q[2] - p[2]));
    }
    if (std::fabs(nearest) < 2e-3 * k_cell) *doubtful = true;
    if (nearest < 0) continue;
    const double y = share[0] * a[1] + share[1] * b[1] + share[2] * c[1];
    for (const double limit : {ceiling, -0.03, k_flat, -k_flat})
      if (std::fabs(y - limit) < k_unit) *doubtful = true;
    // A steep triangle has many heights within the rounding of a place.
    const double steep = std::max({a[1], b[1], c[1]}) - std::min({a[1], b[1], c[1]});
    if (steep / std::sqrt(std::fabs(area)) > 100) *doubtful = true;
    if (y <= ceiling && y >= -0.03) best = std::max(best, y);
  }
  return best;
}

TEST(KnownPlace, IsTheHighestOfAnyTriangles) {
  uint64_t state = 1;
  const auto random = [&](double low, double high) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(state >> 40) / 16777216.0;
  };
  uint32_t compared = 0, doubted = 0;
  for (int scene = 0; scene < 6; ++scene) {
    Triangles t;
    const double size = scene % 2 == 0 ? 0.05 : 0.9;  // small ones, and some that reach beyond the map
    for (int i = 0; i < (scene % 2 == 0 ? 400 : 12); ++i) {
      const Point at = {random(-0.7, 0.7), random(-0.05, 0.4), random(-0.7, 0.7)};
      const auto near = [&] {
        return Point{at[0] + random(-size, size), at[1] + random(-0.1, 0.1), at[2] + random(-size, size)};
      };
      t.triangle(near(), near(), near());
    }
    const std::vector<float> heights = all(shown(t.told(), 0.3f));
    for (uint32_t i = 0; i < heights.size(); ++i) {
      bool doubtful = false;
      double truth = highest(t, 0.3f, middle(i % k_cells), middle(i / k_cells), &doubtful);
      if (truth == -1 || std::fabs(truth) < k_flat) truth = 0;
      ++(doubtful ? doubted : compared);
      if (doubtful) continue;
      ASSERT_NEAR(heights[i], truth, 2 * k_rounded) << scene << " cell " << i;
    }
  }
  EXPECT_LT(doubted, compared / 20);
}

// A mesh of any turn has no cracks between its triangles.
TEST(KnownPlace, HasNoCracks) {
  for (const double turn : {0.0, 0.1, std::numbers::pi / 4, 1.3}) {
    Triangles t;
    constexpr int k_side = 90;
    const auto at = [&](int i, int j) {
      const double x = (i - k_side / 2) * 0.013, z = (j - k_side / 2) * 0.013;
      return Point{x * std::cos(turn) - z * std::sin(turn), 0.1, x * std::sin(turn) + z * std::cos(turn)};
    };
    for (int i = 0; i < k_side; ++i)
      for (int j = 0; j < k_side; ++j) t.square(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    const std::vector<float> heights = all(shown(t.told()));
    for (uint32_t i = 0; i < heights.size(); ++i)
      if (std::hypot(middle(i % k_cells), middle(i / k_cells)) < 0.57) {
        ASSERT_EQ(heights[i], 0.1f) << turn << " " << i;
      }
  }
}

TEST(KnownPlace, GoesWithItsMesh) {
  Triangles box = the_box(), other;
  other.box({0.3, 0, 0.3}, {0.5, 0.02, 0.5});
  const sandglass_cast_mesh both[2] = {*box.told(), *other.told()};
  Relief relief = made();
  EXPECT_TRUE(relief.set_meshes(both, 2));
  relief.run();
  const auto two = [](double x, double z) {
    return std::fabs(x - 0.4) < 0.1 && std::fabs(z - 0.4) < 0.1 ? 0.02 : on_box(x, z);
  };
  EXPECT_EQ(wrong(relief, two), 0u);
  EXPECT_TRUE(relief.set_meshes(both, 2));
  EXPECT_EQ(relief.run(), 0u);  // the same again
  EXPECT_TRUE(relief.set_meshes(both + 1, 1));
  relief.run();
  EXPECT_EQ(
      wrong(relief, [](double x, double z) { return std::fabs(x - 0.4) < 0.1 && std::fabs(z - 0.4) < 0.1 ? 0.02 : 0; }),
      0u);
  EXPECT_TRUE(relief.set_meshes(nullptr, 0));
  relief.run();
  EXPECT_EQ(wrong(relief, [](double, double) { return 0; }), 0u);
  EXPECT_EQ(relief.heights().version, 3u);
}

// A reset forgets what images have shown. What the app knows it has told already.
TEST(KnownPlace, ImagesChangeItAndAResetBringsItBack) {
  Triangles box = the_box();
  Relief relief = shown(box.told());
  DepthOfBox empty(false);
  for (int look = 0; look < 16; ++look) EXPECT_TRUE(relief.set_image(empty.image));
  EXPECT_EQ(wrong(relief, [](double, double) { return 0; }), 0u);
  relief.reset();
  relief.run();
  EXPECT_EQ(wrong(relief, on_box), 0u);
}

TEST(KnownPlace, IsTheSameUnitByUnit) {
  Triangles t;
  for (int i = 0; i < 900; ++i) {
    const double x = -0.6 + 0.0013 * i, z = 0.5 * std::sin(0.1 * i);
    t.box({x, 0, z}, {x + 0.05, 0.1 + 0.0001 * i, z + 0.3});
  }
  Relief whole = shown(t.told()), parts = made();
  EXPECT_TRUE(parts.set_meshes(t.told(), 1));
  uint32_t units = 0;
  for (; parts.run(1) == 1; ++units) {
  }
  EXPECT_GT(units, t.indices.size() / 3 / 512);
  EXPECT_EQ(all(parts), all(whole));
  EXPECT_EQ(parts.hash(), whole.hash());
}

// While units read it a mesh is replaced: what is shown in the end is the new one, and the old one is not read again.
TEST(KnownPlace, MeshesMayChangeWhileTheyAreRead) {
  Relief relief = made();
  {
    Triangles many;
    for (int i = 0; i < 300; ++i) many.box({-0.5, 0, -0.5}, {0.5, 0.3, 0.5});
    EXPECT_TRUE(relief.set_meshes(many.told(), 1));
    EXPECT_EQ(relief.run(2), 2u);
  }
  Triangles box = the_box();
  EXPECT_TRUE(relief.set_meshes(box.told(), 1));
  relief.run();
  EXPECT_EQ(wrong(relief, on_box), 0u);
}

// ---- The outline

// By how many turns rings go about a point: odd within.
bool within_rings(const std::vector<float>& corners, const std::vector<uint32_t>& counts, double x, double z) {
  size_t first = 0;
  int turns = 0;
  for (const uint32_t count : counts) {
    double angle = 0;
    for (size_t i = 0; i < count; ++i) {
      const size_t a = 2 * (first + i), b = 2 * (first + (i + 1) % count);
      const double ax = corners[a] - x, az = corners[a + 1] - z, bx = corners[b] - x, bz = corners[b + 1] - z;
      angle += std::atan2(ax * bz - az * bx, ax * bx + az * bz);
    }
    turns += static_cast<int>(std::lround(angle / (2 * std::numbers::pi)));
    first += count;
  }
  return turns % 2 != 0;
}

TEST(KnownPlace, OutsideItsOutlineThereIsNothing) {
  const std::vector<float> corners = {-0.503f, -0.4f,  0.5f,  -0.397f, 0.45f,  0.1f, 0.1f,  0.12f, 0.02f,
                                      0.5f,    -0.44f, 0.41f, -0.203f, -0.21f, 0.1f, -0.2f, 0.0f,  -0.05f};
  const std::vector<uint32_t> counts = {6, 3};
  Triangles box = the_box();
  Relief relief = shown(box.told());
  EXPECT_TRUE(relief.set_outline(corners.data(), counts.data(), 2));
  const std::vector<float> heights = all(relief);
  uint32_t gone = 0;
  for (uint32_t i = 0; i < heights.size(); ++i) {
    const double x = middle(i % k_cells), z = middle(i / k_cells);
    const bool within = within_rings(corners, counts, x, z);
    gone += within ? 0 : 1;
    ASSERT_NEAR(heights[i], within ? on_box(x, z) : SANDGLASS_RELIEF_GONE, k_rounded) << x << " " << z;
  }
  EXPECT_GT(gone, 5000u);
  EXPECT_LT(gone, 14000u);
  EXPECT_EQ(relief.heights().version, 2u);
  EXPECT_TRUE(relief.set_outline(corners.data(), counts.data(), 2));
  EXPECT_EQ(relief.heights().version, 2u);
  EXPECT_TRUE(relief.set_outline(nullptr, nullptr, 0));
  EXPECT_EQ(wrong(relief, on_box), 0u);
}

TEST(KnownPlace, RefusesInASentence) {
  Triangles box = the_box();
  Relief relief = shown(box.told());
  const uint64_t hash = relief.hash();
  const char* reason = nullptr;
  sandglass_cast_mesh bad = *box.told();
  bad.stride = 10;
  EXPECT_EQ(sandglass_relief_set_meshes(relief.get(), &bad, 1, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(reason, nullptr);
  const std::vector<sandglass_cast_mesh> many(65, *box.told());
  EXPECT_EQ(sandglass_relief_set_meshes(relief.get(), many.data(), 65, &reason), SANDGLASS_ERROR_CAPACITY);
  const float corners[6] = {0, 0, 1, 0, std::nanf(""), 1};
  const uint32_t two = 2, three = 3;
  EXPECT_EQ(sandglass_relief_set_outline(relief.get(), corners, &two, 1, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_relief_set_outline(relief.get(), corners, &three, 1, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_relief_set_outline(relief.get(), nullptr, &three, 1, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(relief.run(), 0u);
  EXPECT_EQ(relief.hash(), hash);
  // What is no triangle is passed over.
  box.positions[0] = std::nanf("");
  box.indices[5] = 1000000;
  ++box.mesh.version;
  EXPECT_TRUE(relief.set_meshes(box.told(), 1));
  relief.run();
  EXPECT_EQ(wrong(relief, on_box), 0u);  // they were of its bottom
}

}  // namespace
}  // namespace sandglass::tests
