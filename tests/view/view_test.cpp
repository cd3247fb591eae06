// What a user can do in the viewer, without a window: camera and cursor agree, scripts are understood or refused, drawn
// surfaces are closed and have the right volume, sand can be poured and pushed, and grains are drawn between the
// simulated instants.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "models/drawing/render.h"
#include "models/files/failure.h"
#include "models/view/head_up.h"
#include "models/view/input_script.h"
#include "models/view/live_scene.h"
#include "models/view/orbit.h"
#include "models/view/surface.h"
#include "sandglass/sandglass.hpp"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

constexpr double k_all_the_work = 1e6;  // ms, enough for all work on a busy machine and under a sanitizer, too

TEST(Orbit, ThePointUnderAPixelIsDrawnAtThatPixel) {
  Orbit orbit({{0.5, 0.7, 1.2}, {0.1, 0.1, 0.0}, 35.0});
  orbit.turn(0.7, 0.2);
  orbit.zoom(1.3);
  for (const auto& [x, y] : {std::pair(320.0, 240.0), {20.0, 460.0}, {610.0, 300.0}}) {
    const Vec3 at = on_plane(orbit.ray(x, y, 640, 480), 0.0, 100.0);
    EXPECT_EQ(at.y, 0.0);
    const PixelPlace place = project(orbit.camera(), 640, 480, at);
    EXPECT_NEAR(place.x, x, 1e-6);
    EXPECT_NEAR(place.y, y, 1e-6);
  }
}

TEST(Orbit, StartsWhereTheCameraIsAndNeverTurnsOver) {
  const Camera from = {{0.5, 0.7, 1.2}, {0.1, 0.1, 0.0}, 35.0};
  Orbit orbit(from);
  EXPECT_NEAR(length(orbit.camera().eye - from.eye), 0.0, 1e-12);
  orbit.turn(0.0, 100.0);
  const Vec3 up = orbit.camera().eye - from.target;
  EXPECT_GT(up.y, 0.99 * length(up));
  EXPECT_GT(std::hypot(up.x, up.z), 0.0);
}

TEST(InputScript, EventsComeInTheOrderOfTheirFrames) {
  const std::vector<InputEvent> events = parse_input_script("30 up P; 2 down P;\n 2 cursor 10 20.5; 3 press right;");
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0].key, "P");
  EXPECT_EQ(events[1].y, 20.5);
  EXPECT_TRUE(events[2].right_button);
  EXPECT_EQ(events[3].kind, InputKind::key_up);
  EXPECT_TRUE(parse_input_script("").empty());
}

TEST(InputScript, RefusesWhatItDoesNotUnderstand) {
  for (const char* bad : {"down P", "5 dance", "5 cursor 1", "5 cursor 1 nan", "-1 down P", "5 down Meta",
                          "5 press middle", "5 down P Q", "5000000000 down P"})
    EXPECT_THROW(parse_input_script(bad), Failure) << bad;
}

// The enclosed volume of a surface that is closed.
double enclosed(const Mesh& mesh) {
  EXPECT_TRUE(clean_mesh(mesh.vertices, mesh.indices, "surface").report.manifold());
  return signed_volume(mesh);
}

sandglass_collider solid(sandglass_shape shape, float x, float y, float z) {
  sandglass_collider c = cpp::collider(shape, 0, 0, 0);
  c.size[0] = x, c.size[1] = y, c.size[2] = z;
  return c;
}

TEST(Surface, FormulasEncloseTheirVolumes) {
  const auto mesh_of = [](sandglass_shape shape, float x, float y, float z) {
    return collider_mesh(solid(shape, x, y, z), nullptr);
  };
  const double sphere = 4.0 / 3.0 * std::numbers::pi * 0.027, tube = std::numbers::pi * 0.09 * 0.8;
  EXPECT_NEAR(enclosed(mesh_of(SANDGLASS_SHAPE_BOX, 0.1f, 0.2f, 0.3f)), 8 * 0.006, 1e-8);
  // A polyhedron inside the sphere: a little less than the sphere.
  const double ball = enclosed(mesh_of(SANDGLASS_SHAPE_SPHERE, 0.3f, 0, 0));
  EXPECT_LT(ball, sphere);
  EXPECT_GT(ball, 0.97 * sphere);
  EXPECT_NEAR(enclosed(mesh_of(SANDGLASS_SHAPE_CAPSULE, 0.3f, 0.4f, 0)) - ball, tube, 0.01 * tube);
  EXPECT_EQ(mesh_of(SANDGLASS_SHAPE_HALF_SPACE, 1, 1, 1).indices.size(), 0u);
}

// A cylinder as an outline, in both senses of going round it: its drawn faces look to the free side.
TEST(Surface, AFieldIsSeenFromTheFreeSide) {
  const double volume = std::numbers::pi * 0.1 * 0.1 * 0.2;
  for (const char* outline : {"[[0, 0], [0.1, 0], [0.1, 0.2], [0, 0.2]]", "[[0, 0.2], [0.1, 0.2], [0.1, 0], [0, 0]]"})
    for (const auto& [solid_at, sign] : {std::pair("inside", 1.0), {"outside", -1.0}}) {
      SceneFile scene =
          parse_scene(std::string(R"({"particle_radius": 0.01, "bodies": [{"shape": "box", "size": [1, 1, 1]}],
          "colliders": [{"shape": "revolved", "profile": )") +
                          outline + ", \"solid\": \"" + solid_at + "\"}]}",
                      "test.json");
      const CollisionFields fields(&scene, "");
      const sandglass_collider c = collider_over_frame(scene.colliders[0], 0.0, 0.02);
      const Mesh mesh = collider_mesh(c, fields.mesh_of(c.field));
      EXPECT_NEAR(sign * enclosed(mesh), volume, 0.01 * volume) << outline << solid_at;
      const std::vector<float> drawn = flat_triangles(mesh);
      ASSERT_EQ(drawn.size(), 6 * mesh.indices.size());
      for (size_t i = 0; i < drawn.size(); i += 6)  // away from the middle, or towards it
        EXPECT_GT(sign * dot(from_floats(&drawn[i]) - Vec3{0, 0.1, 0}, from_floats(&drawn[i + 3])), 0.0);
    }
}

class Live : public ::testing::Test {
 protected:
  const tests::TemporaryFolder folder;
  const std::string path = folder / "small.json";
  void SetUp() override {
    std::ofstream(path) << R"({"name": "small", "frame_step": 0.02, "particle_radius": 0.01,
      "bodies": [{"shape": "lattice", "counts": [6, 6, 6], "grains": 1000, "position": [0, 0.3, 0]}],
      "colliders": [{"shape": "half_space"}]})";
  }
  LiveOptions options() const {
    LiveOptions o;
    o.scene = path, o.budget_ms = k_all_the_work;
    return o;
  }
};

double mean_height(std::span<const sandglass_grain> grains) {
  double sum = 0.0;
  for (const sandglass_grain& grain : grains) sum += static_cast<double>(grain.position[1]);
  return sum / static_cast<double>(grains.size());
}

// Free fall, with 50 frames a second of the scene and 200 of the display. Every picture shows a later instant than the
// one before, by the time between two pictures of the display.
TEST_F(Live, GrainsAreDrawnBetweenTheSimulatedInstants) {
  LiveScene live(options());
  live.advance(0.02);
  live.advance(0.02);
  double before = mean_height(live.grains()), fallen = 0.0;
  const double simulated = live.report().simulated_time;
  for (int i = 0; i < 3; ++i) {
    live.advance(0.005);
    const double now = mean_height(live.grains());
    fallen += before - now;
    EXPECT_LT(now, before);
    before = now;
  }
  EXPECT_EQ(live.report().simulated_time, simulated);
  // What free fall takes them in the 0.015 s before the state.
  const double earlier = simulated - 0.015, truth = 0.5 * 9.81 * (simulated * simulated - earlier * earlier);
  EXPECT_NEAR(fallen, truth, 0.1 * truth);
}

TEST_F(Live, PouringAddsSandUntilItStops) {
  LiveScene live(options());
  const uint32_t before = live.report().particles;
  live.pour_at(Vec3{0.2, 0.4, 0.0});
  for (int i = 0; i < 20; ++i) live.advance(0.02);
  live.pour_at({});
  live.advance(0.02);
  const uint32_t poured = live.report().particles - before;
  // Area of the nozzle x speed x 0.4 s x density of packed sand / volume of a particle. Sand is added in layers.
  const double expected = 0.6 * 16.0 * 0.6 * 0.4 / (4.0 / 3.0 * 0.01);
  EXPECT_GT(poured, 0.5 * expected);
  EXPECT_LT(poured, 1.7 * expected);
  EXPECT_GT(live.report().grains, 1000u + 3u * poured);
  live.advance(0.02);
  EXPECT_EQ(live.report().particles - before, poured);
  live.restart();
  EXPECT_EQ(live.report().particles, before);
}

TEST_F(Live, ThePushingSphereKeepsItsSpaceFree) {
  LiveScene live(options());
  for (int i = 0; i < 40; ++i) live.advance(0.02);  // until the sand lies on the floor
  const double height = live.floor() + live.push_radius();
  for (int i = 0; i <= 20; ++i) {
    live.push_at(Vec3{-0.2 + 0.01 * i, height, 0.0});
    live.advance(0.02);
  }
  ASSERT_TRUE(live.pushing());
  const sandglass_collider& sphere = live.colliders().back();
  EXPECT_NEAR(sphere.position[0], 0.0f, 1e-6f);
  EXPECT_NEAR(sphere.linear_velocity[0], 0.5f, 1e-4f);
  const std::vector<float>& particles = live.particles();
  for (size_t i = 0; i < particles.size(); i += 3) {
    const double gap = std::hypot(particles[i], particles[i + 1] - height, particles[i + 2]);
    EXPECT_GT(gap, live.push_radius() + 0.5 * live.scene().particle_radius);
  }
  live.push_at({});
  live.advance(0.02);
  EXPECT_EQ(live.colliders().size(), 1u);
}

TEST_F(Live, AJumpingCursorIsNoBlow) {
  LiveScene live(options());
  live.push_at(Vec3{-5.0, 0.05, 0.0});
  live.advance(0.02);
  live.push_at(Vec3{5.0, 0.05, 0.0});
  live.advance(0.02);
  EXPECT_LE(live.colliders().back().linear_velocity[0], 1.0f);
  EXPECT_LT(live.colliders().back().position[0], -4.9f);
}

TEST_F(Live, BudgetAndLightStayInRange) {
  LiveScene live(options());
  for (int i = 0; i < 100; ++i) live.scale_budget(0.5);
  EXPECT_EQ(live.budget_ms(), 0.1);
  live.turn_light(-500.0, 90.0);
  EXPECT_NEAR(live.to_light().y, 1.0, 1e-12);
  live.turn_light(500.0, 0.0);
  EXPECT_NEAR(live.to_light().y, std::cos(85.0 * std::numbers::pi / 180.0), 1e-9);
}

TEST(HeadUp, TheBarIsAsLongAsTheTime) {
  sandglass_frame_report report = {};
  report.elapsed_ns = 3'000'000;
  report.stages[SANDGLASS_STAGE_GRANULAR].elapsed_ns = 1'000'000;
  report.stages[SANDGLASS_STAGE_REFINE].elapsed_ns = 2'000'000;
  HeadUp state;
  state.scene = "x", state.report = &report, state.budget_ms = 4.0;
  const Picture panel = head_up_panel(state);
  const BudgetBar bar = budget_bar();
  const auto length_of = [&](sandglass_stage stage) {
    const Colour c = stage_colour(stage);
    int length = 0;
    for (int x = bar.x; x < bar.x + bar.full_width; ++x) {
      const uint8_t* p = panel.at(x, bar.y + bar.height / 2);
      length += p[0] == c.r && p[1] == c.g && p[2] == c.b;
    }
    return length;
  };
  EXPECT_NEAR(length_of(SANDGLASS_STAGE_GRANULAR), bar.budget_width / 4.0, 1.0);
  EXPECT_NEAR(length_of(SANDGLASS_STAGE_REFINE), bar.budget_width / 2.0, 1.0);
  EXPECT_EQ(length_of(SANDGLASS_STAGE_OUTPUT), 0);
  report.stages[SANDGLASS_STAGE_REFINE].elapsed_ns = 2'000'000'000;  // far over the budget: the bar is cut off
  const Picture full = head_up_panel(state);
  EXPECT_EQ(
      std::vector<uint8_t>(full.at(bar.x + bar.full_width, bar.y + 1), full.at(bar.x + bar.full_width + 1, bar.y + 1)),
      std::vector<uint8_t>(panel.at(bar.x + bar.full_width, bar.y + 1),
                           panel.at(bar.x + bar.full_width + 1, bar.y + 1)));
}

int texels_of(const Picture& picture, Colour colour) {
  int count = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const uint8_t* p = picture.at(x, y);
      count += p[0] == colour.r && p[1] == colour.g && p[2] == colour.b;
    }
  return count;
}

TEST_F(Live, TheLegendNamesTheStagesThatRun) {
  const LiveScene plain(options());
  LiveOptions of_the_shot;
  of_the_shot.scene = "shot", of_the_shot.budget_ms = k_all_the_work;
  const LiveScene shot(of_the_shot);
  for (const auto& [live, shadows] : {std::pair(&plain, false), {&shot, true}}) {
    EXPECT_FALSE(live->runs(SANDGLASS_STAGE_LIGHTING)) << "nothing estimates the light";
    EXPECT_EQ(live->runs(SANDGLASS_STAGE_SHADOW), shadows);
    HeadUp state;
    const sandglass_frame_report report = {};
    state.report = &report, state.budget_ms = 4.0;
    for (sandglass_stage stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) state.runs[stage] = live->runs(stage);
    const Picture panel = head_up_panel(state);
    for (sandglass_stage stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
      EXPECT_EQ(texels_of(panel, stage_colour(stage)) > 0, live->runs(stage)) << stage;
  }
}

// In the viewer too, the shot's sand has the library's own shadow: made within the frame, on floor and sand, and it
// turns with the light.
TEST(LiveShot, TheSandsShadowIsMadeInTheFrame) {
  LiveOptions options;
  options.scene = "shot", options.budget_ms = k_all_the_work;
  LiveScene live(options);
  live.turn_light(30.0, 0.0);                       // to 70 degrees from the zenith
  for (int i = 0; i < 30; ++i) live.advance(0.02);  // until the sand lies on the floor
  ASSERT_TRUE(live.pile(false) && live.pile(true));
  EXPECT_GT(live.report().stages[SANDGLASS_STAGE_SHADOW].units, 0u);
  EXPECT_EQ(live.report().pending_shadows, 0u);
  // The centre of the darkness on the floor, relative to the middle of the rectangle.
  const auto middle_of_the_shadow = [&] {
    const FloorShadow shadow = *live.pile(false);
    double sum = 0.0;
    Vec3 middle;
    for (uint32_t i = 0; i < shadow.texels * shadow.texels; ++i) {
      const double covered = shadow.coverage[i];
      sum += covered;
      const Vec3 texel = {i % shadow.texels + 0.5, 0.0, i / shadow.texels + 0.5};
      middle = middle + texel * (covered * (shadow.high[0] - shadow.low[0]) / shadow.texels);
    }
    EXPECT_GT(sum, 0.0);
    return middle * (1.0 / sum);
  };
  const Vec3 before = middle_of_the_shadow(), light = live.to_light();
  live.turn_light(0.0, 180.0);
  const FloorShadow shadow = *live.pile(false);
  const double texel = (shadow.high[0] - shadow.low[0]) / shadow.texels;
  double moved = 0.0;  // in the next frame, or on a slow (emulated) machine in one of the next few
  for (int i = 0; i < 20 && moved <= texel; ++i) {
    live.advance(0.02);
    const Vec3 by = middle_of_the_shadow() - before;
    moved = by.x * light.x + by.z * light.z;
  }
  EXPECT_GT(moved, texel) << "the shadow must move by more than a texel, to where the light was";
  options.scene = "demo";
  EXPECT_FALSE(LiveScene(options).pile(false)) << "this scene has no such shadow";
}

}  // namespace
}  // namespace sandglass::host
