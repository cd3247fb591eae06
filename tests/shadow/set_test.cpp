// Several objects, several lights, one budget: which texture comes first, that none starves, what the frame call
// promises, and the textures of all lights combined into one.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/virtual_clock.h"
#include "runtime/shadow/baked/shadow.h"
#include "tests/reason.h"
#include "tests/sand_scene.h"
#include "tests/shadow/shadow_fixture.h"

namespace {

using namespace sandglass;
using namespace sandglass::tests;

constexpr uint32_t k_size = SANDGLASS_SHADOW_TEXELS;
constexpr RandomShadow k_network = {32, 1, 6, 4, 11, 0.6f};
constexpr RandomShadow k_rough = {128, 2, 10, 4, 11, 0.6f};  // of which some cells are refined

sandglass_shadow_desc describe_lights(const AssetFile& file, uint32_t lights) {
  sandglass_shadow_desc desc = describe(file);
  desc.light_count = lights;
  return desc;
}

void set_light(LiveShadow& shadow, uint32_t light, float x, float z, float irradiance = 1) {
  const float direction[3] = {x, 1, z};
  ASSERT_EQ(sandglass_shadow_set_light(shadow.shadow, light, direction, irradiance, nullptr), SANDGLASS_OK);
}

TEST(ShadowSet, EveryLightHasTheTextureThatItWouldHaveAlone) {
  const AssetFile file = make_shadow_file(k_network);
  LiveShadow all(describe_lights(file, 3));
  for (uint32_t l = 0; l < 3; ++l) set_light(all, l, 0.3f * static_cast<float>(l), -0.4f);
  all.finish();
  for (uint32_t l = 0; l < 3; ++l) {
    LiveShadow alone(describe(file));
    alone.shade(0.3f * static_cast<float>(l), 1, -0.4f);
    EXPECT_EQ(all.coverage(l), alone.coverage()) << l;
    EXPECT_EQ(all.texture(l).behind, 0u);
  }
  EXPECT_EQ(all.texture(3).valid, 0u);
  EXPECT_EQ(all.texture(3).bytes, nullptr);
}

// The visible change is the turn of the light x its share of the irradiance, over two objects, as the header promises.
TEST(ShadowSet, TheGreatestVisibleChangeComesFirst) {
  const AssetFile file = make_shadow_file(k_network);
  LiveShadow first(describe_lights(file, 2)), second(describe_lights(file, 2));
  sandglass_shadow* both[2] = {first.shadow, second.shadow};
  const LiveShadow* lives[2] = {&first, &second};
  for (uint32_t l = 0; l < 2; ++l) {
    set_light(first, l, 0, 0, l == 0 ? 3 : 1);
    set_light(second, l, 0, 0, 1);
  }
  while (sandglass_shadow_run(both, 2, 1000) > 0) {
  }
  set_light(first, 0, 0.20f, 0, 3);   // 3/4 of the light: change 0.15
  set_light(first, 1, 0.30f, 0, 1);   // 1/4: 0.07
  set_light(second, 0, 0.10f, 0, 1);  // 1/2: 0.05
  set_light(second, 1, 0.50f, 0, 1);  // 1/2: 0.22
  std::vector<uint32_t> order;        // 2 * object + light, as they arrive
  while (sandglass_shadow_run(both, 2, 1) > 0)
    for (uint32_t i = 0; i < 4; ++i)
      if (lives[i / 2]->texture(i % 2).behind == 0 && std::find(order.begin(), order.end(), i) == order.end())
        order.push_back(i);
  EXPECT_EQ(order, (std::vector<uint32_t>{3, 0, 1, 2}));
}

// A light with 90 % of the irradiance turns by half a radian with every call. The weak light moved once, by a tenth of
// a radian. Its change of 1/100 grows by an eighth with every call and has to reach 9/20.
TEST(ShadowSet, AWeakLightWaitsButDoesNotStarve) {
  LiveShadow shadow(describe_lights(make_shadow_file(k_network), 2));
  set_light(shadow, 0, 1, 0, 9);
  set_light(shadow, 1, 0, 0, 1);
  const uint32_t two_textures = sandglass_shadow_run(&shadow.shadow, 1, 100'000);
  uint32_t frames = 0;
  do {
    const float turn = 0.5f * static_cast<float>(++frames);
    set_light(shadow, 0, std::cos(turn), std::sin(turn), 9);
    set_light(shadow, 1, 0.1f, 0, 1);
    sandglass_shadow_run(&shadow.shadow, 1, two_textures / 4);  // a texture every second frame
  } while (shadow.texture(1).behind > 0 && frames < 2000);
  EXPECT_GT(frames, 100u);
  EXPECT_LT(frames, 1000u);
}

TEST(ShadowSet, ALightThatSetsIsNotWaitedFor) {
  LiveShadow shadow(describe_lights(make_shadow_file(k_network), 1));
  shadow.light(0.3f, 1, 0);
  shadow.light(0, -1, 0);
  EXPECT_EQ(sandglass_shadow_units_left(shadow.shadow), 0u);
  EXPECT_EQ(shadow.texture().scale, 0);
  EXPECT_EQ(shadow.texture().behind, 0u);
}

// Two objects with networks of two sizes, one refined and one in full, two lights each. The forecast at any moment is
// compared with the items of the units that then ran. They may differ in two ways: the last unit of each kind of each
// texture is not full but counts as a whole one, and some cells are refined that were not in the light's last texture.
TEST(ShadowSet, TheForecastIsOfTheUnitsThatAreThenRun) {
  const AssetFile rough = make_shadow_file(k_rough), small = make_shadow_file({64, 1, 10, 4, 12, 0.6f});
  sandglass_shadow_desc in_full = describe_lights(small, 2);
  in_full.mode = SANDGLASS_SHADOW_FULL;
  sandglass_shadow_desc refined = describe_lights(rough, 2);
  refined.light_tolerance = in_full.light_tolerance = 0;
  LiveShadow adaptive(refined), full(in_full);
  sandglass_shadow* both[2] = {adaptive.shadow, full.shadow};
  Group group = {{Members{both, 2, k_shadow_kinds}}, 1, 2, k_shadow_kinds, 1.0f, 0};
  const Stage stage = begin_group(&group, {});
  for (const float turn : {0.0f, 0.003f}) {
    uint32_t cells_before[2], cells[2];
    const auto count_cells = [&](uint32_t* of) {
      for (uint32_t l = 0; l < 2; ++l) of[l] = (adaptive.evaluated(l) - k_grid * k_grid) / (k_cell * k_cell - 1);
    };
    if (turn > 0) count_cells(cells_before);
    for (LiveShadow* s : {&adaptive, &full}) {
      set_light(*s, 0, turn, 0.1f);
      set_light(*s, 1, -0.3f, turn, 0.5f);
    }
    std::vector<std::array<uint64_t, k_shadow_kinds>> foreseen, spent;  // at each unit
    std::array<uint64_t, k_shadow_kinds> total = {};
    for (WorkUnit unit; stage.next(&group, 0, &unit); stage.run(&group, 0)) {
      Forecast entries[k_unit_kinds];
      const uint32_t count = stage.forecast(&group, 0, entries);
      foreseen.emplace_back();
      spent.push_back(total);
      for (uint32_t i = 0; i < count; ++i) {
        EXPECT_TRUE(entries[i].spread);
        foreseen.back()[entries[i].kind] += entries[i].items;
      }
      total[unit.kind] += unit.items;
    }
    count_cells(cells);
    for (uint32_t kind = 0; kind < k_shadow_kinds; ++kind) {
      // In the first round no light has a texture yet, so all cells are forecast.
      const ShadowUnit whole = shadow_unit(adaptive.shadow->shadow, kind);
      const auto items_of = [&](uint32_t pieces) {
        return (uint64_t{pieces} * whole.items + whole.pieces - 1) / whole.pieces;
      };
      uint64_t difference = 0;
      if (kind == k_kind_refine)
        for (uint32_t l = 0; l < 2; ++l) {
          const uint32_t expected = turn > 0 ? cells_before[l] : k_cells * k_cells;
          difference += items_of(expected > cells[l] ? expected - cells[l] : cells[l] - expected);
          EXPECT_GT(cells[l], 0u);
        }
      const uint64_t last_units = 2 * (whole.items + shadow_unit(full.shadow->shadow, kind).items);
      for (size_t i = 0; i < foreseen.size(); ++i) {
        const uint64_t then = total[kind] - spent[i][kind];
        // 2, because the forecast of each object is rounded up.
        ASSERT_LE(foreseen[i][kind], then + difference + 2) << kind << " at " << i;
        ASSERT_GE(foreseen[i][kind] + difference + last_units, then) << kind << " at " << i;
      }
      EXPECT_LE(5 * difference, turn > 0 ? total[kind] : ~uint64_t{0});  // otherwise the bound would say little
    }
  }
}

TEST(ShadowSet, RefusesLightsThatItCannotUse) {
  LiveShadow shadow(describe_lights(make_shadow_file(k_network), 2));
  const float up[3] = {0, 1, 0};
  const float nan = std::nanf("");
  for (const std::array<float, 3>& d : {std::array{0.0f, 0.0f, 0.0f}, {nan, 1.0f, 0.0f}, {0.0f, INFINITY, 0.0f}})
    expect_refused("direction", [&](const char** reason) {
      return sandglass_shadow_set_light(shadow.shadow, 0, d.data(), 1, reason);
    });
  EXPECT_EQ(sandglass_shadow_run(&shadow.shadow, 1, 1), 0u);
  EXPECT_EQ(sandglass_shadow_set_light(shadow.shadow, 2, up, 1, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  for (const float irradiance : {-1.0f, nan, INFINITY})
    EXPECT_EQ(sandglass_shadow_set_light(shadow.shadow, 0, up, irradiance, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  for (const uint32_t lights : {0u, SANDGLASS_SHADOW_LIGHTS + 1u}) {
    const AssetFile file = make_shadow_file(k_network);
    sandglass_shadow_desc desc = describe_lights(file, lights);
    uint64_t bytes = 0;
    EXPECT_EQ(sandglass_shadow_bytes(&desc, &bytes, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  }
}

// Visibility nu = sum(E nu) / sum(E) over lights of irradiance E. Each texture is read by bilinear interpolation in
// double.
TEST(ShadowSet, CombinedLightsAreWeightedByTheirIrradiance) {
  LiveShadow shadow(describe_lights(make_shadow_file(k_network), 3));
  set_light(shadow, 0, 0.5f, 0.1f, 2);
  set_light(shadow, 1, -0.6f, 0.4f, 1);
  set_light(shadow, 2, 9.0f, 0, 0.5f);
  shadow.finish();
  ASSERT_LT(shadow.texture(2).scale, 1);  // at atan 9 = 83.7 degrees the light has faded
  constexpr uint32_t k_out = 100;
  std::vector<uint8_t> out(k_out * k_out);
  float low[2], high[2];
  ASSERT_EQ(sandglass_shadow_combine(shadow.shadow, out.data(), k_out, low, high, nullptr), SANDGLASS_OK);
  const double weight[3] = {2, 1, 0.5};
  double worst = 0;
  for (uint32_t v = 0; v < k_out; ++v)
    for (uint32_t u = 0; u < k_out; ++u) {
      const double p[2] = {low[0] + (u + 0.5) / k_out * (high[0] - low[0]),
                           low[1] + (v + 0.5) / k_out * (high[1] - low[1])};
      double sum = 0;
      for (uint32_t l = 0; l < 3; ++l) {
        const sandglass_texture t = shadow.texture(l);
        const double at[2] = {(p[0] - t.corner[0]) / t.along[0] * k_size - 0.5,
                              (p[1] - t.corner[2]) / t.across[2] * k_size - 0.5};
        const auto texel = [&](double x, double y) {
          const bool inside = x >= 0 && y >= 0 && x < k_size && y < k_size;
          return inside ? t.bytes[static_cast<uint32_t>(y) * k_size + static_cast<uint32_t>(x)] / 1.0 : 0.0;
        };
        sum += weight[l] / 3.5 * t.scale * bilinear(texel, at[0], at[1]);
      }
      worst = std::max(worst, std::fabs(sum - out[v * k_out + u]));
    }
  EXPECT_LT(worst, 0.5 + 2.5);  // rounding, and places in steps of 1/256 of a texel between neighbours up to 255 apart
  uint8_t byte = 0;
  EXPECT_EQ(sandglass_shadow_combine(shadow.shadow, &byte, 0, low, high, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(sandglass_shadow_combine(shadow.shadow, &byte, 1025, low, high, nullptr), SANDGLASS_ERROR_INVALID_ARGUMENT);
}

// A light without a texture yet counts as unshaded. Here only one part in ten is known to be in shadow.
TEST(ShadowSet, ALightWithoutATextureYetIsCombinedAsUnshaded) {
  const AssetFile file = make_shadow_file(k_network);
  LiveShadow single(describe(file)), pair(describe_lights(file, 2));
  single.shade(0.5f, 1, 0.1f);
  set_light(pair, 0, 0.5f, 0.1f, 1);
  pair.finish();
  set_light(pair, 1, -0.6f, 0.4f, 9);
  ASSERT_EQ(pair.texture(1).valid, 0u);
  ASSERT_EQ(pair.texture(1).scale, 1.0f);
  constexpr uint32_t k_out = 100;
  std::vector<uint8_t> alone(k_out * k_out), together(k_out * k_out);
  float low[2][2], high[2][2];
  ASSERT_EQ(sandglass_shadow_combine(single.shadow, alone.data(), k_out, low[0], high[0], nullptr), SANDGLASS_OK);
  ASSERT_EQ(sandglass_shadow_combine(pair.shadow, together.data(), k_out, low[1], high[1], nullptr), SANDGLASS_OK);
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_EQ(low[0][axis], low[1][axis]);
    EXPECT_EQ(high[0][axis], high[1][axis]);
  }
  EXPECT_GT(*std::max_element(alone.begin(), alone.end()), 200);
  for (uint32_t i = 0; i < k_out * k_out; ++i) ASSERT_NEAR(together[i], 0.1 * alone[i], 0.55) << i;  // both are rounded
  pair.finish();
  ASSERT_EQ(sandglass_shadow_combine(pair.shadow, together.data(), k_out, low[1], high[1], nullptr), SANDGLASS_OK);
  EXPECT_GT(*std::max_element(together.begin(), together.end()), 100);  // the strong light's shadow
}

// ------------------------------------------------------------------------------------------------------- in the frame

sandglass_frame_report frame(SandScene& sand, const std::vector<sandglass_shadow*>& shadows, uint64_t budget_ns) {
  sandglass_frame_input input = frame_input();
  input.shadows = shadows.data();
  input.shadow_count = static_cast<uint32_t>(shadows.size());
  return sand.frame(input, budget_ns);
}

// With no time at all, one unit a frame still runs: the texture arrives later, and complete. The one before stays.
TEST(ShadowFrame, ABudgetOfNothingStillBringsTheTexture) {
  const AssetFile file = make_shadow_file(k_network);
  for (const sandglass_shadow_mode mode : {SANDGLASS_SHADOW_FULL, SANDGLASS_SHADOW_ADAPTIVE})
    for (const bool has_texture : {false, true}) {
      LiveShadow expected(describe(file, SANDGLASS_ISA_AUTOMATIC, mode));
      LiveShadow shadow(describe(file, SANDGLASS_ISA_AUTOMATIC, mode));
      expected.shade(0.5f, 1, 0.2f);
      VirtualClock time;
      time.step_ns = 1000;
      SandScene sand(virtual_clock(&time));
      if (has_texture) shadow.shade(-1, 1, 0);
      const std::vector<uint8_t> before = shadow.coverage();
      shadow.light(0.5f, 1, 0.2f);
      uint32_t frames = 0;
      for (bool done = false; !done && frames < 2000; ++frames) {
        const uint32_t left = sandglass_shadow_units_left(shadow.shadow);
        const sandglass_frame_report report = frame(sand, {shadow.shadow}, 0);
        ASSERT_EQ(report.stages[SANDGLASS_STAGE_SHADOW].units, 1u);
        ASSERT_LT(sandglass_shadow_units_left(shadow.shadow), left);
        ASSERT_EQ(report.shadows.pending, shadow.texture().behind > 0 ? 1u : 0u);
        done = report.shadows.pending == 0;
        if (!done) {
          ASSERT_EQ(report.shadows.calls_behind, 1u);
          ASSERT_EQ(shadow.texture().valid, has_texture ? 1u : 0u);
          ASSERT_EQ(shadow.coverage(), before);
        }
      }
      EXPECT_GT(frames, 4u);
      EXPECT_EQ(shadow.coverage(), expected.coverage());
      EXPECT_EQ(frame(sand, {shadow.shadow}, 0).stages[SANDGLASS_STAGE_SHADOW].units, 0u);
    }
}

// The least budget that gives the best quality level grows by the measured cost of the texture, and at most so far that
// the cost is the stage's share of the budget.
TEST(ShadowFrame, ATextureCountsForItsCostWhenTheQualityLevelIsChosen) {
  constexpr uint64_t k_ample = 1'000'000'000, k_unit_ns = 1000, k_low = 1 << 19, k_high = 1 << 21, k_near = 1 << 12;
  constexpr double k_share = 0.2;  // the stage's share, as in runtime/scene
  const AssetFile file = make_shadow_file({64, 1, 10, 4, 11, 0.6f});
  struct Waiting {
    uint32_t threshold;
    std::vector<uint32_t> lights;  // that wait for a texture
    uint32_t done;                 // units of their textures that are done
  };
  uint64_t cost = 0;  // of a whole texture
  const auto level_at = [&](const Waiting& waiting, uint64_t budget) {
    sandglass_shadow_desc desc = describe_lights(file, 3);
    desc.threshold = waiting.threshold;
    LiveShadow shadow(desc);
    VirtualClock time;
    time.step_ns = k_unit_ns;
    SandScene sand(virtual_clock(&time));
    for (int f = 0; f < 4; ++f) {
      set_light(shadow, 0, 0.1f * static_cast<float>(f), 0.2f);
      cost = frame(sand, {shadow.shadow}, k_ample).stages[SANDGLASS_STAGE_SHADOW].elapsed_ns;
    }
    for (const uint32_t light : waiting.lights) set_light(shadow, light, -0.3f, 0.2f);
    sandglass_shadow_run(&shadow.shadow, 1, waiting.done);
    return frame(sand, {shadow.shadow}, budget).level;
  };
  const auto budget_min = [&](const Waiting& waiting) {
    uint64_t low = k_low, high = k_high;
    while (high - low > k_near) (level_at(waiting, (low + high) / 2) == 0 ? high : low) = (low + high) / 2;
    return high;
  };
  const double near = 2 * k_near, alone = static_cast<double>(budget_min({255, {}, 0}));
  // No cell of the light's last texture was refined.
  EXPECT_NEAR(static_cast<double>(budget_min({255, {0}, 0})), alone + static_cast<double>(cost), near);
  const uint32_t units_done = static_cast<uint32_t>(cost / k_unit_ns) - 1;
  EXPECT_NEAR(static_cast<double>(budget_min({255, {0}, units_done})), alone + k_unit_ns, near);
  EXPECT_GT(static_cast<double>(cost), 2 * near);  // otherwise the two budgets are the same
  // Two lights without textures, all of whose cells may have to be refined.
  EXPECT_NEAR(static_cast<double>(budget_min({0, {1, 2}, 0})), alone / (1 - k_share), near);
}

TEST(ShadowFrame, WithoutAClockEveryTextureIsDoneInItsFrame) {
  RandomShadow what = k_network;  // with an ambient shadow
  what.version = 2;
  what.ambient_side = 16;
  what.components = 3;
  LiveShadow shadow(describe_lights(make_shadow_file(what), 2));
  SandScene sand;
  set_light(shadow, 0, 0.2f, 0);
  set_light(shadow, 1, 0, 0.5f);
  EXPECT_EQ(frame(sand, {shadow.shadow}, 1).shadows.pending, 0u);
  EXPECT_EQ(shadow.texture(0).valid + shadow.texture(1).valid, 2u);
  sandglass_texture ambient = {};
  ambient.struct_size = sizeof ambient;
  sandglass_shadow_get_ambient(shadow.shadow, &ambient);
  EXPECT_EQ(ambient.version, 1u);
}

TEST(ShadowFrame, RefusesNullAmongTheShadows) {
  SandScene sand;
  frame(sand, {nullptr}, 1'000'000);
  EXPECT_EQ(sand.status, SANDGLASS_ERROR_INVALID_ARGUMENT);
}

}  // namespace
