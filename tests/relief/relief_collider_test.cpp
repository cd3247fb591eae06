// Sand, grains, a skin and bodies on a relief: they lie on it; what rises under them throws nothing, and what falls takes
// them along; what has not changed sleeps on; and bits are the same however frames are cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "platform/virtual_clock.h"
#include "tests/relief/relief_on.h"
#include "tests/sand/granular_scene.h"
#include "tests/skin/skin_scene.h"

namespace {

using namespace sandglass::tests;

constexpr float k_r = 0.005f, k_grain = 0.35f * k_r, k_frame = 1.0f / 60;
constexpr double k_book = 0.03;

sandglass_scene_desc small_sand(uint32_t particles, uint32_t grains = 0) {
  sandglass_scene_desc desc = with_bodies(particles, 1, 64);
  desc.granular.grain_capacity = grains;
  desc.granular.particle_radius = k_r;
  desc.granular.grain_radius = k_grain;
  return desc;
}

double flat(double, double) { return 0; }
// 24 by 16 cm.
double book(double x, double z) { return std::fabs(x) < 0.12 && std::fabs(z) < 0.08 ? k_book : 0; }

struct OnRelief {
  explicit OnRelief(const sandglass_scene_desc& desc) : scene(desc) {
    EXPECT_TRUE(relief.create());
    scene.colliders = {sandglass::floor_at(0), sandglass::relief_collider(relief)};
    for (uint32_t i = 0; i < 2; ++i) scene.colliders[i].id = i + 1;
  }
  sandglass_frame_report frame() {
    const sandglass_frame_report report = scene.frame(k_frame);
    fastest = std::max(fastest, report.sand.speed_max);
    return report;
  }
  sandglass_frame_report run(double seconds) {
    sandglass_frame_report report = {};
    for (int f = 0; f < std::lround(seconds / static_cast<double>(k_frame)); ++f) report = frame();
    return report;
  }
  // Metres, along the normal: how deep the deepest particle is in the relief.
  double deepest() const {
    const std::vector<float> p = scene.positions();
    double deepest = 0;
    for (size_t i = 0; i < p.size(); i += 3) deepest = std::max(deepest, depth(p.data() + i, static_cast<double>(k_r)));
    return deepest;
  }
  double depth(const float* at, double radius) const {
    constexpr double k_small = 1e-5;
    const double x = static_cast<double>(at[0]), z = static_cast<double>(at[2]), h = height_at(relief, x, z),
                 a = (height_at(relief, x + k_small, z) - h) / k_small,
                 b = (height_at(relief, x, z + k_small) - h) / k_small;
    return (h + radius - static_cast<double>(at[1])) / std::sqrt(1 + a * a + b * b);
  }

  sandglass::Relief relief;
  GranularScene scene;
  float fastest = 0;
};

// A block over the book's edge.
std::vector<float> over_the_edge() { return shifted(lattice(14, 12, 14, 2.03f * k_r, k_r), 0.05f, 0.05f, -0.07f); }

TEST(ReliefCollider, CarriesSandAndGrains) {
  const std::vector<float> block = over_the_edge();
  for (const bool control : {false, true}) {
    OnRelief on(small_sand(3000, 20000));
    shape(&on.relief, book);
    on.scene.add(block, {}, grains_about(block, 0.4f * k_r));
    if (control) on.scene.colliders.pop_back();
    const sandglass_frame_report report = on.run(8);
    if (control) {
      EXPECT_GT(on.deepest(), 0.01);
      continue;
    }
    EXPECT_EQ(report.sand.awake, 0u);
    EXPECT_LT(on.deepest(), 0.001);
    uint32_t above = 0, below = 0;
    const std::vector<float> p = on.scene.positions();
    for (size_t i = 0; i < p.size(); i += 3) {
      above += std::fabs(p[i + 1] - static_cast<float>(k_book) - k_r) < 0.1f * k_r;
      below += std::fabs(p[i + 1] - k_r) < 0.1f * k_r;
    }
    EXPECT_GT(above, 100u);
    EXPECT_GT(below, 100u);
    double grain = 0;
    for (const sandglass_grain& g : on.scene.grains)
      if (g.speed >= 0) grain = std::max(grain, on.depth(g.position, static_cast<double>(k_grain)));
    EXPECT_LT(grain, 0.001);
  }
}

// The relief alone is the table; its outline ends at x = 4 cm. The control: without an outline all stays on it.
TEST(ReliefCollider, SandFallsOffTheOutline) {
  const float table[] = {-0.6f, -0.6f, 0.04f, -0.6f, 0.04f, 0.6f, -0.6f, 0.6f};
  const uint32_t corners = 4;
  for (const bool control : {false, true}) {
    OnRelief on(small_sand(3000));
    on.scene.colliders.erase(on.scene.colliders.begin());
    EXPECT_TRUE(on.relief.set_outline(table, &corners, control ? 0 : 1));
    on.scene.add(shifted(lattice(14, 5, 10, 2.03f * k_r, k_r), -0.03f, 0.001f, -0.05f));
    on.run(2);
    uint32_t on_it = 0, off_it = 0, in_it = 0;
    const std::vector<float> p = on.scene.positions();
    for (size_t i = 0; i < p.size(); i += 3) {
      // The edge lies within the last cell.
      on_it += p[i] < 0.05f && p[i + 1] > 0.9f * k_r;
      off_it += p[i + 1] < -0.05f;
      in_it += p[i] < 0.03f && p[i + 1] < 0.8f * k_r && p[i + 1] > -1;
    }
    EXPECT_EQ(in_it, 0u);
    if (control) {
      EXPECT_EQ(off_it, 0u);
      continue;
    }
    EXPECT_EQ(on_it + off_it, p.size() / 3);
    EXPECT_GT(on_it, 150u);
    EXPECT_GT(off_it, 150u);
  }
}

// 8 cm rise at once under a pile. The control: beside a body that is five times as dense, sand leaves what it is in 25
// times as fast.
TEST(ReliefCollider, WhatRisesThrowsNothing) {
  for (const bool control : {false, true}) {
    OnRelief on(small_sand(2200));
    on.scene.add(shifted(lattice(14, 8, 14, 2.03f * k_r, k_r), -0.07f, 0.001f, -0.07f));
    if (control) on.scene.add_body(shifted(lattice(2, 2, 2, 2.0f * k_r, k_r), 0.4f, 0.0f, 0.0f), 5);
    on.run(4);
    on.fastest = 0;
    shape(&on.relief, [](double x, double z) { return std::fabs(x) < 0.05 && std::fabs(z) < 0.05 ? 0.08 : 0; });
    EXPECT_GT(on.deepest(), 0.01);
    const sandglass_frame_report report = on.run(5);
    if (control) {
      EXPECT_GT(on.fastest, 1.5f);
      continue;
    }
    EXPECT_LT(on.fastest, 1.5f);
    EXPECT_LT(on.deepest(), 0.001);
    EXPECT_EQ(report.sand.awake, 0u);
  }
}

TEST(ReliefCollider, WhatIsTakenAwayLeavesNothingFloating) {
  OnRelief on(small_sand(800, 6400));
  shape(&on.relief, book);
  const std::vector<float> layer =
      shifted(lattice(12, 1, 8, 3.0f * k_r, k_r), -0.08f, static_cast<float>(k_book), -0.05f);
  on.scene.add(layer, {}, grains_about(layer, 0.4f * k_r));
  EXPECT_EQ(on.run(3).sand.awake, 0u);
  shape(&on.relief, flat);
  EXPECT_EQ(on.run(3).sand.awake, 0u);
  const std::vector<float> p = on.scene.positions();
  for (size_t i = 1; i < p.size(); i += 3) EXPECT_NEAR(p[i], k_r, 0.05f * k_r);
  for (const sandglass_grain& g : on.scene.grains) EXPECT_TRUE(g.speed < 0 || g.position[1] < 2.1f * k_r);
}

// Particles far from each other, each in the room between four nodes. All those with the changed one among their four wake,
// and no other.
TEST(ReliefCollider, SleepersWakeWhereANodeChangedAndNowhereElse) {
  OnRelief on(small_sand(900));
  std::vector<float> points;
  for (int j = 0; j < 28; ++j)
    for (int i = 0; i < 28; ++i)
      points.insert(points.end(),
                    {0.0131f * static_cast<float>(i) - 0.18f, k_r, 0.0133f * static_cast<float>(j) - 0.18f});
  on.scene.add(points);
  EXPECT_EQ(on.run(2).sand.awake, 0u);
  const std::vector<float> before = on.scene.positions();
  const double middles[][2] = {{0.005, 0.015}, {-0.105, 0.055}, {0.155, -0.125}};
  for (const auto& middle : middles) {
    const auto is_here = [&](double x, double z) {
      return std::fabs(x - middle[0]) < 1e-3 && std::fabs(z - middle[1]) < 1e-3;
    };
    shape(&on.relief, [&](double x, double z) { return is_here(x, z) ? 0.01 : 0; });
    uint32_t over = 0;
    for (size_t i = 0; i < before.size(); i += 3)
      over += std::fabs(static_cast<double>(before[i]) - middle[0]) < 0.01 &&
              std::fabs(static_cast<double>(before[i + 2]) - middle[1]) < 0.01;
    ASSERT_GT(over, 0u);
    EXPECT_EQ(on.frame().sand.awake, over);
    shape(&on.relief, flat);
    on.run(3);
    EXPECT_EQ(on.frame().sand.awake, 0u);
  }
  // What nothing has touched is where it was, to the bit.
  const std::vector<float> after = on.scene.positions();
  uint32_t unmoved = 0;
  for (size_t i = 0; i < before.size(); i += 3) unmoved += std::equal(&before[i], &before[i] + 3, &after[i]);
  EXPECT_GT(unmoved, 28u * 28 - 30);
  // A version that changes nothing wakes nothing.
  shape(&on.relief, flat);
  EXPECT_EQ(on.frame().sand.awake, 0u);
}

TEST(ReliefCollider, BodiesRestOnIt) {
  OnRelief on(small_sand(8));
  shape(&on.relief, book);
  const uint32_t body = on.scene.add_body(shifted(lattice(4, 2, 4, 2.0f * k_r, k_r), -0.02f, 0.05f, -0.02f), 2);
  EXPECT_EQ(on.run(3).sand.awake, 0u);
  const float bottom = on.scene.scene.body_pose(body).position[1] - 2 * k_r;
  EXPECT_NEAR(bottom, k_book, 0.1f * k_r);
  shape(&on.relief, flat);
  EXPECT_EQ(on.run(3).sand.awake, 0u);
  EXPECT_NEAR(on.scene.scene.body_pose(body).position[1] - 2 * k_r, 0, 0.1f * k_r);
}

// Triangles near the book that face downward: a skin has none where sand lies on it. The control is one that is closed
// there.
TEST(ReliefCollider, ASkinIsOpenWhereSandMeetsIt) {
  for (const uint32_t closed : {0u, 1u}) {
    Sand sand(rough(300), closed);
    sandglass::Relief relief;
    ASSERT_TRUE(relief.create());
    shape(&relief, [](double x, double z) { return std::fabs(x) < 0.3 && std::fabs(z) < 0.3 ? k_book : 0; });
    sand.scene.colliders.push_back(sandglass::relief_collider(relief));
    sand.lie(shifted(block(6, 4, 6), 0.0f, static_cast<float>(k_book), 0.0f));
    sand.until_rested();
    const sandglass_skin_mesh mesh = sand.skin.mesh();
    uint32_t bottom = 0, triangles = 0;
    for (uint32_t c = 0; c < mesh.chunk_count; ++c) {
      const sandglass_skin_chunk& chunk = mesh.chunks[c];
      for (uint32_t t = 0; t < chunk.index_count; t += 3) {
        const float* p[3];
        for (uint32_t v = 0; v < 3; ++v) p[v] = chunk.vertices[chunk.indices[t + v]].position;
        const float up = (p[1][2] - p[0][2]) * (p[2][0] - p[0][0]) - (p[1][0] - p[0][0]) * (p[2][2] - p[0][2]);
        ++triangles;
        bottom += up < 0 && std::max({p[0][1], p[1][1], p[2][1]}) < static_cast<float>(k_book) + 0.5f * k_radius;
      }
    }
    EXPECT_GT(triangles, 100u);
    EXPECT_EQ(bottom > 20, closed != 0) << bottom;
    EXPECT_TRUE(closed != 0 || bottom == 0) << bottom;
  }
}

// What a recorded frame is given beside its plan.
struct Recorded {
  sandglass_plan plan;
  uint64_t hash;
};

void on_threads(void*, sandglass_task_function task, void* context, uint32_t count) {
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([=] {
      for (uint32_t i = t; i < count; i += 4) task(context, i);
    });
  for (std::thread& thread : threads) thread.join();
}

// Sand that falls over the book's edge, on a relief that changes in the frame 40 and 80.
template <class Frame>
void pour(OnRelief* on, const Frame& frame) {
  shape(&on->relief, book);
  const std::vector<float> block = over_the_edge();
  on->scene.add(block, {}, grains_about(block, 0.4f * k_r));
  for (int f = 0; f < 120; ++f) {
    if (f == 40) shape(&on->relief, [](double x, double z) { return 2 * book(x - 0.03, z); });
    if (f == 80) shape(&on->relief, flat);
    frame(f);
  }
}

// Every budget, unit, pool and instruction set: replayed from plans that a clock has cut.
TEST(ReliefCollider, OneHashHoweverFramesAreCut) {
  sandglass::VirtualClock clock{.step_ns = 2000};
  sandglass_scene_desc desc = small_sand(3000, 20000);
  desc.clock = sandglass::virtual_clock(&clock);
  desc.unit_items = 64;
  desc.isa = SANDGLASS_ISA_SCALAR;
  std::vector<Recorded> frames;
  uint64_t denied = 0;
  {
    OnRelief on(desc);
    pour(&on, [&](int f) {
      const sandglass_frame_report report = on.scene.frame(k_frame, f % 3 == 0 ? 400'000u : 4'000'000u);
      denied += report.stages[SANDGLASS_STAGE_GRANULAR].denied;
      frames.push_back({report.plan, on.scene.hash()});
    });
  }
  EXPECT_GT(denied, 0u);
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_AVX512; ++isa) {
    if (sandglass_isa_available(isa) == 0) continue;
    desc.clock = {};
    desc.isa = isa;
    desc.parallel.run = on_threads;
    OnRelief on(desc);
    pour(&on, [&](int f) {
      on.scene.frame(k_frame, f % 3 == 0 ? 400'000u : 4'000'000u, &frames[static_cast<size_t>(f)].plan);
      ASSERT_EQ(on.scene.hash(), frames[static_cast<size_t>(f)].hash) << sandglass_isa_name(isa) << ", frame " << f;
    });
  }
}

// With the heights restored, sand sleeps on; without them it falls.
TEST(ReliefCollider, ASavedSceneGoesOnWhereItsHeightsDo) {
  OnRelief first(small_sand(3000));
  shape(&first.relief, book);
  first.scene.add(over_the_edge());
  first.run(5);
  std::vector<std::byte> scene, heights;
  accept(first.scene.scene.save(&scene));
  EXPECT_TRUE(first.relief.save(&heights));
  for (const bool control : {false, true}) {
    OnRelief second(small_sand(3000));
    EXPECT_TRUE(control || second.relief.restore(heights));
    accept(second.scene.scene.restore(scene));
    second.run(1);
    if (control) {
      const std::vector<float> p = second.scene.positions();
      EXPECT_LT(p[1], static_cast<float>(k_book)) << "nothing holds it";
      continue;
    }
    first.run(1);
    EXPECT_EQ(second.scene.hash(), first.scene.hash());
    EXPECT_LT(second.deepest(), 0.001);
  }
}

TEST(ReliefCollider, BeyondTheMapSandFallsPast) {
  OnRelief on(small_sand(8));
  on.scene.colliders = {on.scene.colliders[1]};
  on.scene.add({0.60f, 0.05f, 0, 0.66f, 0.05f, 0});  // the map ends at 0.64
  on.run(1);
  const std::vector<float> p = on.scene.positions();
  EXPECT_NEAR(p[1], k_r, 0.1f * k_r);
  EXPECT_LT(p[4], -2.0f);
}

TEST(ReliefCollider, MovesWithItsPlane) {
  OnRelief on(small_sand(100));
  shape(&on.relief, book);
  on.scene.add(shifted(lattice(4, 1, 4, 3.0f * k_r, k_r), 0, static_cast<float>(k_book), 0));
  on.run(2);
  const float lower[3] = {0, -0.01f, 0};
  EXPECT_TRUE(on.relief.set_plane(lower, {0, 0, 0, 1}));
  on.scene.colliders[0] = sandglass::floor_at(-0.01f);
  on.scene.colliders[1] = sandglass::relief_collider(on.relief);
  for (uint32_t i = 0; i < 2; ++i) on.scene.colliders[i].id = i + 1;
  EXPECT_EQ(on.run(3).sand.awake, 0u);
  EXPECT_NEAR(on.scene.positions()[1], static_cast<float>(k_book) - 0.01f + k_r, 0.1f * k_r);
}

TEST(ReliefCollider, ASinkAndARegionAreWhatLiesBelow) {
  OnRelief on(small_sand(8));
  shape(&on.relief, book);
  on.scene.colliders.pop_back();
  on.scene.add({0, 0.01f, 0, 0.2f, 0.01f, 0, 0, 0.05f, 0.03f});
  uint32_t removed = 0;
  accept(on.scene.scene.remove(sandglass::relief_collider(on.relief), &removed));
  EXPECT_EQ(removed, 1u);
  on.scene.sinks = {sandglass::relief_collider(on.relief)};
  on.run(1);
  EXPECT_EQ(on.frame().sand.particles, 1u);
}

TEST(ReliefCollider, OneWithoutAReliefIsLeftOut) {
  OnRelief on(small_sand(8));
  on.scene.colliders[1].relief = nullptr;
  EXPECT_EQ(on.frame().sand.ignored_colliders, 1u);
  sandglass_collider unchanged = sandglass::sphere(1, 2, 3, 4);
  sandglass_relief_get_collider(nullptr, &unchanged);
  EXPECT_EQ(unchanged.shape, SANDGLASS_SHAPE_SPHERE);
  sandglass_relief_get_collider(on.relief.get(), nullptr);
}

}  // namespace
