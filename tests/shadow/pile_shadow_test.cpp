// The sand's own shadow: against rays cast at its spheres, the promises of its header, and its place in the frame.
#include "sandglass/pile_shadow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/filled_struct.h"
#include "tests/guarded_block.h"
#include "tests/reason.h"

namespace {

using sandglass::tests::expect_refused;

constexpr double k_degree = std::numbers::pi / 180.0;
constexpr float k_radius = 0.01f;   // of particles
constexpr float k_grain = 0.0035f;  // radius of grains; a texel is larger

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

// A hexagonal lattice of spheres where `inside` holds.
std::vector<float> spheres_in(const std::function<bool(const float*)>& inside, float reach, float height) {
  std::vector<float> points;
  const sandglass::Box box{{-reach, k_radius, -reach}, {reach, height, reach}};
  auto test = [&](const float* p) { return inside(p); };
  EXPECT_TRUE(sandglass::sample_lattice(box, 2 * k_radius, test, &points));
  return points;
}

std::vector<float> pile() {  // a cone as steep as sand gets
  return spheres_in([](const float* p) { return std::hypot(p[0], p[2]) < 0.16f - 1.8f * p[1]; }, 0.2f, 0.1f);
}
std::vector<float> tower() {  // a column as it begins to collapse
  return spheres_in([](const float* p) { return std::hypot(p[0], p[2]) < 0.08f - 0.2f * p[1]; }, 0.1f, 0.18f);
}

// The share of the light's irradiance that reaches a point, by rays through the centres of equal parts of the light's
// cap.
double traced(const std::vector<float>& spheres, const double (&point)[3], const Light& light,
              float radius = k_radius) {
  constexpr int k_side = 12;
  const std::array<double, 3> d = light.vector();
  const double flat = std::hypot(d[0], d[2]);
  const double u[3] = {-d[2] / flat, 0, d[0] / flat};
  double v[3];
  for (size_t k = 0; k < 3; ++k) v[k] = d[(k + 1) % 3] * u[(k + 2) % 3] - d[(k + 2) % 3] * u[(k + 1) % 3];
  double all = 0, open = 0;
  for (int i = 0; i < k_side; ++i)
    for (int j = 0; j < k_side; ++j) {
      const double cosine = 1 - (i + 0.5) / k_side * (1 - std::cos(10 * k_degree)),
                   sine = std::sqrt(1 - cosine * cosine);
      const double turn = 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / k_side;
      double r[3];
      for (size_t k = 0; k < 3; ++k) r[k] = cosine * d[k] + sine * (std::cos(turn) * u[k] + std::sin(turn) * v[k]);
      if (r[1] <= 0) continue;
      all += r[1];
      bool hit = false;
      for (size_t s = 0; s < spheres.size() && !hit; s += 3) {
        double along = 0, square = 0;
        for (size_t k = 0; k < 3; ++k) {
          const double to = static_cast<double>(spheres[s + k]) - point[k];
          along += to * r[k], square += to * to;
        }
        hit = along > 0 && square - along * along < static_cast<double>(radius * radius);
      }
      open += hit ? 0 : r[1];
    }
  return open / all;
}

struct Error {
  double rmse = 0, without = 0;  // errors of visibility, with the shadow and with no shadow at all
  int points = 0;
};

// The errors over a lattice of floor points in shadow or near it, beside the sand and not under it.
Error error_of(const std::vector<float>& spheres, const Light& light, uint32_t texels) {
  sandglass_pile_shadow_desc desc = description();
  desc.texels = texels;
  sandglass::PileShadow shadow = lit(light, desc);
  shadow.run(spheres, k_radius);
  const sandglass_pile_shadow_texture t = shadow.texture();
  EXPECT_EQ(t.valid, 1u);
  Error error;
  for (uint32_t i = 0; i < 24; ++i)
    for (uint32_t j = 0; j < 24; ++j) {
      const uint32_t u = (2 * i + 1) * texels / 48, v = (2 * j + 1) * texels / 48;
      const double point[3] = {-0.5 + (u + 0.5) / texels, 0, -0.5 + (v + 0.5) / texels};
      bool under = false;
      for (size_t s = 0; s < spheres.size() && !under; s += 3)
        under = spheres[s + 1] < 2 * k_radius && std::hypot(static_cast<double>(spheres[s]) - point[0],
                                                            static_cast<double>(spheres[s + 2]) - point[2]) < 0.02;
      if (under) continue;
      const double truth = traced(spheres, point, light), shown = 1 - t.coverage[v * texels + u] / 255.0;
      if (truth > 0.999 && shown > 0.999) continue;
      error.rmse += (truth - shown) * (truth - shown), error.without += (1 - truth) * (1 - truth);
      ++error.points;
    }
  error.rmse = std::sqrt(error.rmse / error.points), error.without = std::sqrt(error.without / error.points);
  return error;
}

void expect_truth(const char* what, const std::vector<float>& sand, const Light& light, double limit) {
  const Error error = error_of(sand, light, 128);
  ASSERT_GT(error.points, 10) << what << " at " << light.polar_deg;
  EXPECT_LT(error.rmse, limit) << what << " at " << light.polar_deg;
  EXPECT_GT(error.without, 4 * error.rmse)
      << what << " at " << light.polar_deg << ": the error without a shadow must be larger";
  std::printf("%s, light at %g degrees: RMSE %.4f, of no shadow %.4f, %d points\n", what, light.polar_deg, error.rmse,
              error.without, error.points);
}

TEST(PileShadow, IsWhatRaysSay) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "a million rays";
  const std::vector<float> steep = tower(), flat = pile();
  // The limits are the measured errors plus a quarter.
  for (const Light light : {Light{50, 200}, Light{65, 305}}) expect_truth("tower", steep, light, 0.0525);
  expect_truth("pile", flat, {68, 100}, 0.035);
}

TEST(PileShadow, OfSandInTheAirStandsOffFromItsFoot) {
  const std::vector<float> ball =
      spheres_in([](const float* p) { return std::hypot(std::hypot(p[0], p[2]), p[1] - 0.2f) < 0.06f; }, 0.1f, 0.3f);
  const Light light = {45, 0};  // light from +x: the shadow's centre is 0.2 m on the other side
  expect_truth("ball", ball, light, 0.0515);
  expect_truth("ball", ball, {4, 70}, 0.063);
  sandglass::PileShadow shadow = lit(light);
  shadow.run(ball, k_radius);
  const sandglass_pile_shadow_texture t = shadow.texture();
  const auto at = [&](double x, double z) {
    return t.coverage[static_cast<size_t>((z + 0.5) * 128) * 128 + static_cast<size_t>((x + 0.5) * 128)];
  };
  EXPECT_GT(at(-0.2, 0), 200) << "in the shadow";
  EXPECT_EQ(at(0, 0), 0) << "below the ball";
  EXPECT_EQ(at(0.2, 0), 0) << "on the light's side";
}

// A thin layer with less than one grain a texel.
TEST(PileShadow, OfScatteredGrainsIsNotThatOfFullTexels) {
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "ten million rays";
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<float> grains;
  while (grains.size() < 3 * 700) {
    const float x = 0.15f * unit(random), z = 0.15f * unit(random);
    if (std::hypot(x, z) < 0.15f) grains.insert(grains.end(), {x, k_grain, z});
  }
  for (const double polar : {20.0, 45.0, 65.0}) {
    const Light light = {polar, 200};
    sandglass::PileShadow shadow = lit(light);
    shadow.run(grains, k_grain);
    const sandglass_pile_shadow_texture t = shadow.texture();
    double truth = 0, shown = 0, points = 0;
    for (int i = 0; i < 600; ++i) {
      const double point[3] = {static_cast<double>(0.12f * unit(random)), 0, static_cast<double>(0.12f * unit(random))};
      bool under = false;
      for (size_t s = 0; s < grains.size() && !under; s += 3)
        under = std::hypot(static_cast<double>(grains[s]) - point[0], static_cast<double>(grains[s + 2]) - point[2]) <
                static_cast<double>(k_grain);
      if (under) continue;
      const auto texel = [](double x) { return static_cast<size_t>((x + 0.5) * 128); };
      truth += traced(grains, point, light, k_grain);
      shown += 1 - t.coverage[texel(point[2]) * 128 + texel(point[0])] / 255.0, points += 1;
    }
    // The limit is the largest measured difference (0.02 to 0.036) plus a quarter. Full columns would be far too dark.
    EXPECT_NEAR(shown / points, truth / points, 0.045) << "light at " << polar;
    EXPECT_GT(1 - truth / points, 0.1) << "light at " << polar << ": there must be a shadow to compare";
  }
}

TEST(PileShadow, OneHashForAllKernelsAndAllDivisions) {
  const std::vector<float> sand = pile();
  uint64_t first = 0;
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_AVX512; ++isa) {
    if (sandglass_isa_available(isa) == 0) continue;
    for (const uint32_t units : {1u, 7u, 100000u}) {
      sandglass_pile_shadow_desc desc = description();
      desc.isa = isa;
      sandglass::PileShadow shadow = lit({55, 130}, desc);
      while (shadow.run(sand, k_radius, units) != 0) {
      }
      const uint64_t hash = shadow.hash();
      if (first == 0) first = hash;
      EXPECT_EQ(hash, first) << sandglass_isa_name(isa) << ", " << units << " units at a time";
    }
  }
  EXPECT_EQ(first, 6054312259728143041ull) << "the hash must be the same on every machine";
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
  refused("angular_diameter", [](auto* d) { d->angular_diameter = 2; });
  refused("light_tolerance", [](auto* d) { d->light_tolerance = -1; });
  refused("on_sand", [](auto* d) { d->on_sand = 2; });

  const sandglass_pile_shadow_desc desc = description();
  uint64_t bytes = 0;
  ASSERT_EQ(sandglass_pile_shadow_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
  sandglass::test::GuardedBlock block(bytes);
  sandglass_pile_shadow* handle = nullptr;
  EXPECT_EQ(sandglass_pile_shadow_create(&desc, block.data(), bytes - 1, &handle, nullptr),
            SANDGLASS_ERROR_MEMORY_TOO_SMALL);
  EXPECT_EQ(sandglass_pile_shadow_create(&desc, block.data() + 1, bytes, &handle, nullptr),
            SANDGLASS_ERROR_MEMORY_ALIGNMENT);
  EXPECT_TRUE(block.untouched());
  ASSERT_EQ(sandglass_pile_shadow_create(&desc, block.data(), bytes, &handle, nullptr), SANDGLASS_OK);
  const auto set_light = [&](const std::array<float, 3>& d) {
    return sandglass_pile_shadow_set_light(handle, d.data(), nullptr);
  };
  const std::array<float, 3> good = {1e-20f, 3e-20f, 0};
  EXPECT_EQ(set_light({0, 0, 0}), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(set_light({0, NAN, 0}), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(set_light(good), SANDGLASS_OK);
  EXPECT_EQ(set_light({1, -0.1f, 0}), SANDGLASS_OK);
  EXPECT_EQ(sandglass_pile_shadow_run(handle, nullptr, 0, k_radius, 10), 0u)
      << "a light below the horizon leaves nothing to do";
  // Spheres that are not finite, far away or below the floor are left out.
  const float wild[] = {NAN, 0, 0, 1e30f, 0.1f, 0, 0, INFINITY, 0, 0, -5, 0, 0, 0.1f, NAN};
  EXPECT_EQ(set_light(good), SANDGLASS_OK);
  EXPECT_GT(sandglass_pile_shadow_run(handle, wild, 5, k_radius, 100000), 0u);
  sandglass_pile_shadow_texture t = {};
  t.struct_size = sizeof t;
  sandglass_pile_shadow_get_texture(handle, &t);
  ASSERT_EQ(t.valid, 1u);
  EXPECT_TRUE(std::all_of(t.coverage, t.coverage + 128 * 128, [](uint8_t c) { return c == 0; }));
  EXPECT_TRUE(block.guards_intact());
}

TEST(PileShadow, FillsNoByteBeyondTheCallersTexture) {
  sandglass::PileShadow shadow = lit({40, 90});
  sandglass::tests::expect_filled_within_its_size<sandglass_pile_shadow_texture>(
      [&](sandglass_pile_shadow_texture* texture) {
        sandglass_pile_shadow_get_texture(shadow.get(), texture);
        return true;
      },
      false);
}

// A block of sand falls, spreads and comes to rest. Each frame has one unit of shadow beside all of the sand's work.
TEST(PileShadow, FollowsTheSandOfAScene) {
  sandglass_scene_desc desc = sandglass::scene_desc();
  const std::vector<float> sand = pile();
  const auto count = static_cast<uint32_t>(sand.size() / 3);
  desc.granular.particle_capacity = count, desc.granular.collider_capacity = 1;
  const uint64_t bytes = sandglass::Scene::bytes(desc);
  sandglass::PileShadow shadow = lit({40, 90});
  EXPECT_EQ(sandglass::Scene::bytes(desc), bytes) << "the shadow must not make the scene larger";
  sandglass::Scene scene;
  ASSERT_TRUE(scene.create(desc));
  ASSERT_TRUE(scene.add(sand));
  const sandglass_collider floor = sandglass::floor_at(0);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = 1.0f / 60.0f, input.budget_ns = UINT64_MAX;
  input.colliders = &floor, input.collider_count = 1;
  input.pile_shadow = shadow.get();
  sandglass_frame_report report = sandglass::frame_report();
  uint32_t worked = 0, rested = 0;
  for (int frame = 0; frame < 600; ++frame) {
    ASSERT_TRUE(scene.frame(input, &report));
    worked += report.stages[SANDGLASS_STAGE_SHADOW].units != 0 ? 1 : 0;
    rested = report.awake == 0 && report.stages[SANDGLASS_STAGE_SHADOW].units == 0 ? rested + 1 : 0;
    if (rested == 10) break;
  }
  EXPECT_EQ(rested, 10u) << "the shadow of sand at rest must cost nothing";
  EXPECT_GT(worked, 10u);
  const sandglass_pile_shadow_texture t = shadow.texture();
  EXPECT_EQ(t.valid, 1u);
  EXPECT_EQ(t.age, 0u);
  // The texture that the frames made is the one that the positions give.
  std::vector<float> positions(sand.size());
  sandglass_granular_particles(scene.get(), positions.data(), nullptr);
  sandglass::PileShadow again = lit({40, 90});
  again.run(positions, k_radius);
  EXPECT_EQ(again.hash(), shadow.hash());
  // The shadow follows a light that turns.
  EXPECT_TRUE(shadow.set_light(Light{40, 120}.floats()));
  ASSERT_TRUE(scene.frame(input, &report));
  EXPECT_GT(report.stages[SANDGLASS_STAGE_SHADOW].units, 0u);
}

}  // namespace
