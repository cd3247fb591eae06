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
#include "sandglass/sandglass.hpp"
#include "tests/filled_struct.h"
#include "tests/guarded_block.h"
#include "tests/reason.h"
#include "tests/shadow/pile_fixture.h"

namespace {

using namespace sandglass::tests;
using sandglass::host::SphereCaster;
using sandglass::host::Vec3;

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

// The share of the light's irradiance that reaches a point, by rays through the centres of equal parts of the light's
// cap.
double traced(const SphereCaster& spheres, const Vec3& point, const Light& light) {
  constexpr int k_side = 12;
  const std::array<double, 3> d = light.vector();
  const Vec3 middle = {d[0], d[1], d[2]}, u = normalised(Vec3{-d[2], 0, d[0]}), v = cross(middle, u);
  double all = 0, open = 0;
  for (int i = 0; i < k_side; ++i)
    for (int j = 0; j < k_side; ++j) {
      const double cosine = 1 - (i + 0.5) / k_side * (1 - std::cos(10 * k_degree)),
                   sine = std::sqrt(1 - cosine * cosine);
      const double turn = 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / k_side;
      const Vec3 r = middle * cosine + (u * std::cos(turn) + v * std::sin(turn)) * sine;
      if (r.y <= 0) continue;
      all += r.y;
      open += spheres.occluded(point, r, 10) ? 0 : r.y;
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
  const SphereCaster caster(spheres, k_radius);
  for (uint32_t i = 0; i < 24; ++i)
    for (uint32_t j = 0; j < 24; ++j) {
      const uint32_t u = (2 * i + 1) * texels / 48, v = (2 * j + 1) * texels / 48;
      const Vec3 point = {-0.5 + (u + 0.5) / texels, 0, -0.5 + (v + 0.5) / texels};
      bool under = false;
      for (size_t s = 0; s < spheres.size() && !under; s += 3)
        under = spheres[s + 1] < 2 * k_radius && std::hypot(static_cast<double>(spheres[s]) - point.x,
                                                            static_cast<double>(spheres[s + 2]) - point.z) < 0.02;
      if (under) continue;
      const double truth = traced(caster, point, light), shown = 1 - t.coverage[v * texels + u] / 255.0;
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
  const std::vector<float> ball = spheres_in(
      [](const float* p) { return std::hypot(std::hypot(p[0], p[2]), p[1] - 0.2f) < 0.06f; }, k_radius, 0.1f, 0.3f);
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
  const std::vector<float> grains = scattered();
  const SphereCaster caster(grains, k_grain);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-0.12, 0.12);
  for (const double polar : {25.0, 45.0, 65.0}) {
    const Light light = {polar, 200};
    sandglass::PileShadow shadow = lit(light);
    shadow.run(grains, k_grain);
    const sandglass_pile_shadow_texture t = shadow.texture();
    double truth = 0, shown = 0, points = 0;
    for (int i = 0; i < 6000; ++i) {
      const double x = unit(random), z = unit(random);
      if (caster.occluded({x, 0, z}, {0, 1, 0}, 2 * double{k_grain})) continue;  // the point is under a grain
      const auto texel = [](double metres) { return static_cast<size_t>((metres + 0.5) * 128); };
      truth += traced(caster, {x, 0, z}, light);
      shown += 1 - t.coverage[texel(z) * 128 + texel(x)] / 255.0, points += 1;
    }
    // The measured differences are 0.01 to 0.041. Full columns would be far too dark.
    EXPECT_NEAR(shown / points, truth / points, 0.045) << "light at " << polar;
    EXPECT_GT(1 - truth / points, 0.1) << "light at " << polar << ": there must be a shadow to compare";
  }
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

// A pile of sand slides and comes to rest. The shadow's units stand beside all of the sand's work.
TEST(PileShadow, FollowsTheSandOfAScene) {
  sandglass_scene_desc desc = sandglass::scene_desc();
  const std::vector<float> sand = pile();
  desc.granular.particle_capacity = static_cast<uint32_t>(sand.size() / 3), desc.granular.collider_capacity = 1;
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
    rested = falling.report.awake == 0 && units == 0 ? rested + 1 : 0;
  }
  EXPECT_EQ(rested, 10u) << "the shadow and the light of sand at rest must cost nothing";
  EXPECT_GT(worked, 10u);
  EXPECT_EQ(shadow.texture().valid & shadow.sky().valid, 1u);
  EXPECT_EQ(shadow.texture().age | shadow.sky().age, 0u);
  // The textures that the frames made are those that the positions give.
  std::vector<float> positions(sand.size());
  sandglass_granular_particles(falling.scene.get(), positions.data(), nullptr);
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
