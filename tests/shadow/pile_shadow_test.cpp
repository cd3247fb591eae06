// The sand's own shadow: against rays cast at its spheres, the promises of its header, and its place in the frame.
#include "sandglass/pile_shadow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "models/tracing/sphere_caster.h"
#include "runtime/shadow/pile/pile.h"
#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"
#include "tests/measured.h"
#include "tests/reason.h"
#include "tests/shadow/pile_fixture.h"

namespace {

using namespace sandglass::tests;
using sandglass::host::SphereCaster;
using sandglass::host::Vec3;
using sandglass::test::measured;

constexpr double k_degree = std::numbers::pi / 180.0;
constexpr float k_radius = 0.01f;  // of particles

struct Light {
  double polar_deg, azimuth_deg;
  std::array<double, 3> vector() const {
    const double polar = polar_deg * k_degree, azimuth = azimuth_deg * k_degree;
    return {std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth)};
  }
  std::array<float, 3> floats() const {
    const std::array<double, 3> d = vector();
    return {static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2])};
  }
};

sandglass_pile_shadow_desc description() {
  sandglass_pile_shadow_desc desc;
  sandglass_pile_shadow_desc_default(&desc);
  return desc;
}

sandglass::PileShadow lit(const Light& light, const sandglass_pile_shadow_desc& desc = description()) {
  sandglass::PileShadow shadow;
  EXPECT_TRUE(shadow.create(desc));
  EXPECT_TRUE(shadow.set_light(light.floats()));
  return shadow;
}

std::vector<float> pile() {  // a cone as steep as sand gets
  return spheres_in([](const float* p) { return std::hypot(p[0], p[2]) < 0.16f - 1.8f * p[1]; }, k_radius, 0.2f, 0.1f);
}
std::vector<float> tower() {  // a column as it begins to collapse
  return spheres_in([](const float* p) { return std::hypot(p[0], p[2]) < 0.08f - 0.2f * p[1]; }, k_radius, 0.1f, 0.18f);
}

// A book on the floor, and what is read between the middles of cells of a centimetre.
struct Book {
  float height;
  std::vector<float> cells = std::vector<float>(100 * 100);
  static bool covers(double x, double z) {
    return std::fabs(0.96 * x + 0.28 * z + 0.11) < 0.12 && std::fabs(0.96 * z - 0.28 * x) < 0.17;
  }
  explicit Book(float h) : height(h) {
    for (size_t i = 0; i < cells.size(); ++i)
      cells[i] =
          covers(0.01 * static_cast<double>(i % 100) - 0.495, 0.01 * static_cast<double>(i / 100) - 0.495) ? h : 0.0f;
  }
  sandglass_heights map() const {
    return {sizeof(sandglass_heights),
            {100, 100},
            cells.data(),
            0.01f,
            {-0.5f, 0, -0.5f},
            {1, 0, 0},
            {0, 0, 1},
            {0, 1, 0},
            1,
            {},
            {},
            1};
  }
  double at(double x, double z) const { return covers(x, z) ? static_cast<double>(height) : 0.0; }
  bool ends_near(double x, double z) const {
    int on = 0;
    for (const double dx : {-0.015, 0.0, 0.015})
      for (const double dz : {-0.015, 0.0, 0.015}) on += covers(x + dx, z + dz) ? 1 : 0;
    return on % 9 != 0;
  }
  // What it hides is dark without sand, too.
  bool hides(const Vec3& point, const Vec3& direction) const {
    constexpr int k_steps = 100;
    for (int i = 1; i <= k_steps && point.y < static_cast<double>(height) - 1e-4; ++i) {
      const Vec3 p = point + direction * ((static_cast<double>(height) - point.y) / direction.y * i / (k_steps + 1));
      if (covers(p.x, p.z)) return true;
    }
    return false;
  }
};

struct Traced {
  double before, left;  // with the book alone, and with the sand
};

// The shares of the light's irradiance that reach a point, by rays through the centres of equal parts of the light's
// cap.
Traced traced(const SphereCaster& spheres, const Vec3& point, const Light& light, const Book& book = Book(0)) {
  constexpr int k_side = 12;
  const std::array<double, 3> d = light.vector();
  const Vec3 middle = {d[0], d[1], d[2]}, u = normalised(Vec3{-d[2], 0, d[0]}), v = cross(middle, u);
  double all = 0, before = 0, open = 0;
  for (int i = 0; i < k_side; ++i)
    for (int j = 0; j < k_side; ++j) {
      const double cosine = 1 - (i + 0.5) / k_side * (1 - std::cos(10 * k_degree)),
                   sine = std::sqrt(1 - cosine * cosine);
      const double turn = 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / k_side;
      const Vec3 r = middle * cosine + (u * std::cos(turn) + v * std::sin(turn)) * sine;
      if (r.y <= 0) continue;
      all += r.y;
      if (book.hides(point, r)) continue;
      before += r.y;
      open += spheres.occluded(point, r, 10) ? 0 : r.y;
    }
  return {before / all, open / all};
}

struct Error {
  double rmse = 0, without = 0;  // errors of visibility, with the shadow and with no shadow at all
  int points = 0;
};

// The errors over a lattice of points of the ground in shadow or near it, beside the sand and not under it.
Error error_of(const std::vector<float>& spheres, const Light& light, uint32_t texels, const Book& book = Book(0),
               bool is_told = true) {
  sandglass_pile_shadow_desc desc = description();
  desc.texels = texels;
  sandglass::PileShadow shadow = lit(light, desc);
  if (book.height > 0 && is_told) {
    EXPECT_TRUE(shadow.set_ground(book.map()));
  }
  shadow.run(spheres, k_radius);
  const sandglass_texture t = shadow.texture();
  EXPECT_EQ(t.valid, 1u);
  Error error;
  const SphereCaster caster(spheres, k_radius);
  for (uint32_t i = 0; i < 24; ++i)
    for (uint32_t j = 0; j < 24; ++j) {
      const uint32_t u = (2 * i + 1) * texels / 48, v = (2 * j + 1) * texels / 48;
      Vec3 point = {-0.5 + (u + 0.5) / texels, 0, -0.5 + (v + 0.5) / texels};
      point.y = book.at(point.x, point.z);
      bool under = book.height > 0 && book.ends_near(point.x, point.z);
      for (size_t s = 0; s < spheres.size() && !under; s += 3)
        under =
            static_cast<double>(spheres[s + 1]) < point.y + 2 * static_cast<double>(k_radius) &&
            std::hypot(static_cast<double>(spheres[s]) - point.x, static_cast<double>(spheres[s + 2]) - point.z) < 0.02;
      if (under) continue;
      const auto [before, truth] = traced(caster, point, light, book);
      const double shown = before * (1 - t.bytes[v * texels + u] / 255.0);
      if (truth > 0.999 * before && shown > 0.999 * before) continue;
      error.rmse += (truth - shown) * (truth - shown);
      error.without += (before - truth) * (before - truth);
      ++error.points;
    }
  error.rmse = std::sqrt(error.rmse / error.points);
  error.without = std::sqrt(error.without / error.points);
  return error;
}

void expect_truth(const char* what, const std::vector<float>& sand, const Light& light, double limit) {
  const Error error = error_of(sand, light, 128);
  ASSERT_GT(error.points, 10) << what << " at " << light.polar_deg;
  EXPECT_LT(error.rmse, limit) << what << " at " << light.polar_deg;
  EXPECT_GT(error.without, 4 * error.rmse)
      << what << " at " << light.polar_deg << ": the error without a shadow must be larger";
  const std::string name = std::string(what) + ", light at " + std::to_string(static_cast<int>(light.polar_deg));
  measured(name, "rmse", error.rmse);
  measured(name, "without", error.without);
}

TEST(PileShadow, IsWhatRaysSay) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "a million rays";
  const std::vector<float> steep = tower(), flat = pile();
  // The limits are the measured errors plus a quarter.
  for (const Light light : {Light{50, 200}, Light{65, 305}}) expect_truth("tower", steep, light, 0.0525);
  expect_truth("pile", flat, {68, 100}, 0.035);
}

// A pile that lies over a book's edge, against the same pile on the floor, and the book as nobody told it. Heights between
// the book's and the floor's are left out: they are the map's alone.
TEST(PileShadow, FallsOnWhatStandsThere) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "a million rays";
  const Book book(0.04f);
  const std::vector<float> over = spheres_in(
      [&](const float* p) {
        const float above = p[1] - static_cast<float>(book.at(static_cast<double>(p[0]), static_cast<double>(p[2])));
        return above > 0 && std::hypot(p[0], p[2]) < 0.14f - 1.5f * above;
      },
      k_radius, 0.2f, 0.16f);
  const std::vector<float> flat =
      spheres_in([](const float* p) { return std::hypot(p[0], p[2]) < 0.14f - 1.5f * p[1]; }, k_radius, 0.2f, 0.16f);
  double level = 0, told = 0, untold = 0;  // squares
  for (const Light light : {Light{55, 20}, Light{60, 340}, Light{65, 50}, Light{62, 200}}) {
    const auto square = [&](const Error& error) { return error.rmse * error.rmse / 4; };
    level += square(error_of(flat, light, 128));
    told += square(error_of(over, light, 128, book));
    untold += square(error_of(over, light, 128, book, false));
  }
  EXPECT_LT(std::sqrt(told), 1.5 * std::sqrt(level));
  EXPECT_GT(std::sqrt(untold), 1.5 * std::sqrt(level)) << "control";
  measured("over a book", "rmse", std::sqrt(told));
  measured("over a book", "on the floor", std::sqrt(level));
  measured("over a book", "not told", std::sqrt(untold));
}

// A plane that trembles by a hundredth of a texel makes no texture anew; one that moves by a texel does.
TEST(PileShadow, OfAPlaneThatTremblesIsMadeOnce) {
  const Book book(0.04f);
  const std::vector<float> sand = pile();
  sandglass::PileShadow shadow = lit({50, 20});
  const auto units = [&](float moved, uint64_t version) {
    sandglass_heights map = book.map();
    map.corner[0] += moved / 128;
    map.version = version;
    EXPECT_TRUE(shadow.set_ground(map));
    return shadow.run(sand, k_radius);
  };
  EXPECT_GT(units(0, 1), 0u);
  EXPECT_EQ(units(0, 1), 0u);
  EXPECT_EQ(units(0.01f, 1), 0u);
  EXPECT_GT(units(1, 1), 0u);
  EXPECT_GT(units(1, 2), 0u);
}

TEST(PileShadow, OfSandInTheAirStandsOffFromItsFoot) {
  const std::vector<float> ball = spheres_in(
      [](const float* p) { return std::hypot(std::hypot(p[0], p[2]), p[1] - 0.2f) < 0.06f; }, k_radius, 0.1f, 0.3f);
  const Light light = {45, 0};  // light from +x: the shadow's centre is 0.2 m on the other side
  expect_truth("ball", ball, light, 0.0515);
  expect_truth("ball", ball, {4, 70}, 0.063);
  sandglass::PileShadow shadow = lit(light);
  shadow.run(ball, k_radius);
  const sandglass_texture t = shadow.texture();
  const auto at = [&](double x, double z) {
    return t.bytes[static_cast<size_t>((z + 0.5) * 128) * 128 + static_cast<size_t>((x + 0.5) * 128)];
  };
  EXPECT_GT(at(-0.2, 0), 200) << "in the shadow";
  EXPECT_EQ(at(0, 0), 0) << "below the ball";
  EXPECT_EQ(at(0.2, 0), 0) << "on the light's side";
}

// ---- thin layers

// Grains on the floor of half a square metre, independently of each other: their outlines together have `coverage`
// times the area.
constexpr double k_layer_side = 0.5;
std::vector<float> layer(double radius, double coverage, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-0.25f, 0.25f);
  const auto count = static_cast<size_t>(coverage * k_layer_side * k_layer_side / (std::numbers::pi * radius * radius));
  std::vector<float> grains;
  for (size_t i = 0; i < count; ++i) {
    const float x = place(random), z = place(random);
    grains.insert(grains.end(), {x, static_cast<float>(radius), z});
  }
  return grains;
}
// Points of the floor that no grain covers, away from the layer's edges.
std::vector<Vec3> open_points(const SphereCaster& caster, double radius, int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.2, 0.2);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), z = place(random);
    if (!caster.occluded({x, 0, z}, {0, 1, 0}, 2 * radius)) points.push_back({x, 0, z});
  }
  return points;
}
// The visibility of a light that a layer leaves in the mean to such points. A ray is free with the probability
// exp(-A coverage / pi): A is the area of the ellipse that is a sphere's shadow, less what of it lies in the sphere's
// outline; the sphere of radius 1 stands in the ellipse's focus. Both meet at the angle `meet`.
double open_share(double polar_deg, double coverage) {
  constexpr int k_rings = 24, k_turns = 48, k_steps = 400;
  const auto area = [](double sine) {
    const double cosine = std::sqrt(1 - sine * sine), meet = std::acos((1 - sine) / cosine);
    double sum = 0;
    for (int i = 0; i < k_steps; ++i) {
      const double radius = sine / (1 - cosine * std::cos((i + 0.5) / k_steps * meet));
      sum += (radius * radius - 1) * meet / k_steps;
    }
    return sum;
  };
  double all = 0, open = 0;
  for (int i = 0; i < k_rings; ++i)
    for (int j = 0; j < k_turns; ++j) {  // equal parts of the light's cap, as in `traced`
      const double cosine = 1 - (i + 0.5) / k_rings * (1 - std::cos(10 * k_degree)),
                   sine = std::sqrt(1 - cosine * cosine), turn = 2 * std::numbers::pi * (j + 0.5) / k_turns;
      const double up =
          cosine * std::cos(polar_deg * k_degree) + sine * std::cos(turn) * std::sin(polar_deg * k_degree);
      all += up;
      open += up * std::exp(-coverage / std::numbers::pi * area(up));
    }
  return open / all;
}

TEST(PileShadow, TheTruthOfAThinLayerIsThatOfRays) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "millions of rays";
  constexpr double k_fine = 0.002, k_coverage = 0.38;
  const std::vector<float> grains = layer(k_fine, k_coverage, 3);
  const SphereCaster caster(grains, static_cast<float>(k_fine));
  const std::vector<Vec3> points = open_points(caster, k_fine, 20000, 4);
  for (const double polar : {25.0, 65.0}) {
    double truth = 0;
    for (const Vec3& point : points) truth += traced(caster, point, {polar, 200}).left;
    // Four standard deviations of the mean of 13,000 points, most of which see much less or more than the mean.
    EXPECT_NEAR(truth / static_cast<double>(points.size()), open_share(polar, k_coverage), 0.012) << polar;
  }
}

// The mean over the points that a viewer sees between the grains. Texels are two to six grains' radii wide.
TEST(PileShadow, OfAThinLayerIsTrueToAHundredth) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "a million rays";
  double worst = 0;
  for (const double per_texel : {0.16, 0.3, 0.448})  // the radius
    for (const double coverage : {0.1, 0.25, 0.4}) {
      const double radius = per_texel * k_layer_side / 128;
      const std::vector<float> grains = layer(radius, coverage, 5);
      const std::vector<Vec3> points = open_points(SphereCaster(grains, static_cast<float>(radius)), radius, 20000, 6);
      for (const Light light : {Light{5, 200}, Light{25, 35}, Light{45, 200}, Light{45, 35}, Light{65, 35}}) {
        sandglass_pile_shadow_desc desc = description();
        std::fill_n(desc.low, 2, -0.25f);
        std::fill_n(desc.high, 2, 0.25f);
        sandglass::PileShadow shadow = lit(light, desc);
        shadow.run(grains, static_cast<float>(radius));
        const sandglass_texture t = shadow.texture();
        double shown = 0;
        for (const Vec3& point : points) {
          const auto texel = [](double metres) { return static_cast<size_t>((metres + 0.25) * 256); };
          shown += 1 - t.bytes[texel(point.z) * 128 + texel(point.x)] / 255.0;
        }
        const double error = shown / static_cast<double>(points.size()) - open_share(light.polar_deg, coverage);
        EXPECT_NEAR(error, 0, 0.01) << per_texel << " coverage " << coverage << " light " << light.polar_deg;
        worst = std::max(worst, std::fabs(error));
      }
    }
  measured("thin layers", "worst", worst);
}

// ---- bounds

// Against every texel, in double: what is covered is within the reach, and the reach is within the texture.
TEST(PileShadow, ReachesNoTexelBeyondTheTexture) {
  const sandglass::PileShadow shadow = lit({40, 90});
  const sandglass::Pile& pile = shadow.get()->pile;
  const int32_t n = 128;
  const auto check = [&](float x, float y, float z, float radius) {
    const float centre[3] = {x, y, z};
    const sandglass::PileReach reach = sandglass::pile_reach(pile.rectangle, centre, radius);
    for (int axis = 0; axis < 2; ++axis) {
      if (reach.last[axis] < reach.first[axis]) continue;
      ASSERT_GE(reach.first[axis], 0) << x << ' ' << y << ' ' << z << ' ' << radius;
      ASSERT_LT(reach.last[axis], n) << x << ' ' << y << ' ' << z << ' ' << radius;
    }
    const double r = static_cast<double>(radius) * (1 - 1e-5);  // beyond what float can tell
    if (!(std::fabs(x) < 100 && std::fabs(z) < 100 && y < 100 && y > -radius && radius < 100)) return;
    for (int32_t v = 0; v < n; ++v)
      for (int32_t u = 0; u < n; ++u) {
        const double dx = (u + 0.5) / n - 0.5 - static_cast<double>(x),
                     dz = (v + 0.5) / n - 0.5 - static_cast<double>(z);
        if (std::hypot(dx, dz) >= r - 1e-5) continue;
        ASSERT_TRUE(u >= reach.first[0] && u <= reach.last[0] && v >= reach.first[1] && v <= reach.last[1])
            << u << ' ' << v << " of " << x << ' ' << y << ' ' << z << ' ' << radius;
      }
  };
  const float wild[] = {0,     -0.0f, 0.3f,  -0.6f,  10,  -10,      5e3f,      -1e9f,
                        3e18f, 1e30f, 3e38f, -3e38f, NAN, INFINITY, -INFINITY, 1e-40f};
  for (const float x : wild)
    for (const float y : wild)
      for (const float z : wild)
        for (const float radius : wild) check(x, y, z, radius);
  std::mt19937 random(8);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (int i = 0; i < 100; ++i) check(unit(random), 0.1f * unit(random), unit(random), std::exp(4 * unit(random) - 3));
}

// A unit visits at most so many columns, whatever the radius. Unclipped, the first sphere alone has 1.6 million.
TEST(PileShadow, WorkOfAUnitIsBoundedForEverySphere) {
  constexpr uint32_t k_spheres = 200, k_columns = 128 * 128, k_rows = 2 * k_columns / sandglass::k_pile_unit_texels;
  std::vector<float> spheres;
  for (uint32_t i = 0; i < k_spheres; ++i) spheres.insert(spheres.end(), {0.001f * static_cast<float>(i), -4.9f, 0});
  sandglass::PileShadow shadow = lit({40, 90});
  EXPECT_EQ(shadow.run(spheres, 5), k_spheres * k_columns / sandglass::k_pile_unit_columns + k_rows);
  EXPECT_EQ(shadow.texture().valid, 1u);
  // The columns are those of the spheres: the highest is 0.1 m above the floor.
  EXPECT_NEAR(shadow.get()->pile.columns.top, 0.1f, 1e-4f);
  for (const float radius : {1e7f, INFINITY, NAN, 3e38f, 0.0f, -1.0f}) {
    shadow.refresh();
    EXPECT_LE(shadow.run(spheres, radius), 1 + k_rows) << radius << ": no sphere is left";
    const sandglass_texture t = shadow.texture();
    EXPECT_TRUE(std::all_of(t.bytes, t.bytes + k_columns, [](uint8_t c) { return c == 0; })) << radius;
  }
  // In pieces or at once, spheres with many columns give one texture.
  sandglass::PileShadow whole = lit({40, 90}), pieces = lit({40, 90});
  whole.run(spheres, 4.95f);
  while (pieces.run(spheres, 4.95f, 1) != 0) continue;
  EXPECT_EQ(pieces.hash(), whole.hash());
}

TEST(PileShadow, RefusesWithASentence) {
  const auto refused = [](const char* words, void (*spoil)(sandglass_pile_shadow_desc*)) {
    sandglass_pile_shadow_desc desc = description();
    spoil(&desc);
    uint64_t bytes = 0;
    expect_refused(words, [&](const char** reason) { return sandglass_pile_shadow_bytes(&desc, &bytes, reason); });
  };
  refused("struct_size", [](auto* d) { d->struct_size = 3; });
  refused("above low", [](auto* d) { d->high[0] = d->low[0]; });
  refused("low or high", [](auto* d) { d->low[1] = NAN; });
  refused("floor", [](auto* d) { d->floor = INFINITY; });
  refused("texels", [](auto* d) { d->texels = 100; });
  refused("light_tolerance", [](auto* d) { d->light_tolerance = -1; });
  refused("on_sand", [](auto* d) { d->on_sand = 2; });

  const sandglass_pile_shadow_desc desc = description();
  uint64_t bytes = 0;
  ASSERT_EQ(sandglass_pile_shadow_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
  sandglass::test::GuardedBlock block(bytes);
  sandglass_pile_shadow* handle = nullptr;
  ASSERT_EQ(sandglass_pile_shadow_create(&desc, block.data(), bytes, &handle, nullptr), SANDGLASS_OK);
  const auto set_light = [&](const std::array<float, 3>& d, float width = 0) {
    return sandglass_pile_shadow_set_light(handle, d.data(), width, nullptr);
  };
  const auto set_ground = [&](void (*spoil)(sandglass_heights*)) {
    static const Book book(0.03f);
    sandglass_heights map = book.map();
    spoil(&map);
    return sandglass_pile_shadow_set_ground(handle, &map, nullptr);
  };
  EXPECT_EQ(set_ground([](auto*) {}), SANDGLASS_OK);
  for (void (*spoil)(sandglass_heights*) :
       {+[](sandglass_heights* m) { m->struct_size = 8; }, +[](sandglass_heights* m) { m->heights = nullptr; },
        +[](sandglass_heights* m) { m->cells[1] = 1; }, +[](sandglass_heights* m) { m->cells[0] = 257; },
        +[](sandglass_heights* m) { m->corner[2] = NAN; }, +[](sandglass_heights* m) { m->along[0] = 0; }})
    EXPECT_EQ(set_ground(spoil), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_pile_shadow_set_ground(handle, nullptr, nullptr), SANDGLASS_OK);
  const std::array<float, 3> good = {1e-20f, 3e-20f, 0};
  EXPECT_EQ(set_light({0, 0, 0}), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(set_light({0, NAN, 0}), SANDGLASS_ERROR_INVALID_ARGUMENT);
  for (const float width : {-0.1f, 1.6f, NAN}) EXPECT_EQ(set_light({0, 1, 0}, width), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(set_light(good), SANDGLASS_OK);
  EXPECT_EQ(set_light({1, -0.1f, 0}), SANDGLASS_OK);
  EXPECT_EQ(sandglass_pile_shadow_run(handle, nullptr, 0, k_radius, 10), 0u)
      << "a light below the horizon leaves nothing to do";
  // Spheres that are not finite, far away or below the floor are left out.
  const float wild[] = {NAN, 0, 0, 1e30f, 0.1f, 0, 0, INFINITY, 0, 0, -5, 0, 0, 0.1f, NAN};
  EXPECT_EQ(set_light(good), SANDGLASS_OK);
  EXPECT_GT(sandglass_pile_shadow_run(handle, wild, 5, k_radius, 100000), 0u);
  sandglass_texture t = {};
  t.struct_size = sizeof t;
  sandglass_pile_shadow_get_texture(handle, SANDGLASS_PILE_SHADOW_FLOOR, &t);
  ASSERT_EQ(t.valid, 1u);
  EXPECT_TRUE(std::all_of(t.bytes, t.bytes + 128 * 128, [](uint8_t c) { return c == 0; }));
  EXPECT_TRUE(block.guards_intact());
}

// A pile of sand slides and comes to rest. The shadow's units stand beside all of the sand's work.
TEST(PileShadow, FollowsTheSandOfAScene) {
  sandglass_scene_desc desc = sandglass::scene_desc();
  const std::vector<float> sand = pile();
  desc.granular.particle_capacity = static_cast<uint32_t>(sand.size() / 3);
  desc.granular.collider_capacity = 1;
  const uint64_t bytes = sandglass::Scene::bytes(desc);
  sandglass_pile_shadow_desc with_sky = description();
  with_sky.sky_texels = 64;
  sandglass::PileShadow shadow = lit({40, 90}, with_sky);
  EXPECT_EQ(sandglass::Scene::bytes(desc), bytes) << "the shadow must not make the scene larger";
  SandOnTheFloor falling(desc);
  ASSERT_TRUE(falling.scene.add(sand));
  falling.input.pile_shadow = shadow.get();
  const uint32_t& units = falling.report.stages[SANDGLASS_STAGE_SHADOW].units;
  uint32_t worked = 0, rested = 0;
  for (int frame = 0; frame < 600 && rested < 10; ++frame) {
    falling.frame();
    worked += units != 0 ? 1 : 0;
    rested = falling.report.sand.awake == 0 && units == 0 ? rested + 1 : 0;
  }
  EXPECT_EQ(rested, 10u) << "the shadow and the light of sand at rest must cost nothing";
  EXPECT_GT(worked, 10u);
  EXPECT_EQ(shadow.texture().valid & shadow.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR).valid, 1u);
  EXPECT_EQ(shadow.texture().behind | shadow.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR).behind, 0u);
  // The textures that the frames made are those that the positions give.
  std::vector<float> positions(sand.size());
  sandglass_scene_particles(falling.scene.get(), positions.data(), nullptr);
  sandglass::PileShadow again = lit({40, 90}, with_sky);
  again.run(positions, k_radius);
  EXPECT_EQ(again.hash(), shadow.hash());
  // They follow a light that turns, and the light of a room.
  EXPECT_TRUE(shadow.set_light(Light{40, 120}.floats()));
  falling.frame();
  EXPECT_GT(units, 0u);
  for (int frame = 0; frame < 10; ++frame) falling.frame();
  EXPECT_EQ(units, 0u);
  std::array<float, SANDGLASS_LIGHT_CELLS> cells{};
  cells[20] = 1;
  ASSERT_TRUE(shadow.set_cells(cells));
  falling.frame();
  EXPECT_GT(units, 0u);
}

}  // namespace
