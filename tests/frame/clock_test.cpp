// A phone's clock is not steady: heat slows a core, light work goes to a smaller one, a frame is held up. The phone's scene
// (1,560 particles, 27,000 grains, a hand that stirs without end) runs under clocks like that. A work unit costs the
// instructions that were counted for it (models/phones) with noise: log-normal of 12 %, one unit in 200 twice as long. All
// is virtual, so every machine sees the same frames.
//
// An app draws between its last two buffers, as sandglass.h says (report.sand.shown_time). Drawing grains as they were
// written is the control.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "fake_scene.h"
#include "models/phones/phone.h"
#include "platform/virtual_clock.h"
#include "runtime/scene/scene.h"
#include "sandglass/sandglass.hpp"
#include "tests/sand/granular_scene.h"

namespace sandglass::governor_test {
namespace {

constexpr double k_x3 = 8.2, k_a78 = 5.09;  // instructions a nanosecond
constexpr double k_pi = 3.14159265358979;

// Slower builds and emulated processors take minutes, and see the same.
constexpr bool k_runs = k_case_frames >= 1000000;

struct Noise {
  uint64_t state;
  double uniform() {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (static_cast<double>(state >> 11) + 0.5) * 0x1p-53;
  }
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
};

// How costs change: not; by 3 or 4 in every other span; by 4 in one frame of 20; by 3 in the first 10 frames; up to 7 times
// as much by heat, and down again.
enum class Clock { steady, spans_of_2s, spans_of_quarter, slow_frames, cold, heat };
// The governor learns costs; is told the clock's speed in each frame; or takes the first second's for granted.
enum class Speed { learned, given, assumed };

struct Case {
  Clock clock;
  double budget_ms;  // 2: at 120 Hz, else 60; 0: 1 to 6 at random in each frame
  double seconds;
  double core = k_x3;
  Speed speed = Speed::learned;
  uint32_t better_after = k_predictor_policy.better_after;
  bool skin = false;  // is drawn, and there are no grains
};

// Of what is drawn: frames in which it stands, and the second difference of moving grains from frame to frame.
struct Drawing {
  double frozen_percent, jerk_mm;
};

struct Seen {
  Drawing even, written;
  // Frames that end after their budget, and by more than a work unit.
  double late_percent, late_by_more_percent;
  double lost_percent;  // of the time
  double levels;        // changes a second
  double behind_ms;     // what is drawn, the grains
  double new_skins_percent;
};

using Positions = std::vector<sandglass_grain>;

class Jerk {
 public:
  void add(const Positions& now) {
    for (size_t i = 0; i < now.size() && !before_.empty(); ++i) {
      if (!(now[i].speed > 0.05f)) continue;
      for (int k = 0; k < 3; ++k) {
        const double newer = static_cast<double>(now[i].position[k]) - static_cast<double>(last_[i].position[k]);
        const double older = static_cast<double>(last_[i].position[k]) - static_cast<double>(before_[i].position[k]);
        squares_ += (newer - older) * (newer - older);
      }
      ++count_;
    }
    before_ = last_;
    last_ = now;
  }
  double mm() const { return count_ == 0 ? 0 : 1e3 * std::sqrt(squares_ / static_cast<double>(count_)); }

 private:
  Positions before_, last_;
  double squares_ = 0;
  uint64_t count_ = 0;
};

// What an app does.
struct App {
  struct Buffer {
    Positions grains;
    double time;
  } older, newer;
  double drawn = 0;  // the instant

  Positions draw(const Positions& written, const sandglass_sand_report& sand) {
    if (newer.grains.empty()) older = newer = {written, sand.grains_time};
    if (sand.grains_time > newer.time) {
      older = newer;
      newer = {written, sand.grains_time};
    }
    const double span = newer.time - older.time;
    const double share = span > 0 ? std::clamp((sand.shown_time - older.time) / span, 0.0, 1.0) : 1;
    drawn = older.time + share * span;
    Positions mixed = newer.grains;
    for (size_t i = 0; i < mixed.size(); ++i)
      for (int k = 0; k < 3; ++k)
        mixed[i].position[k] = older.grains[i].position[k] +
                               static_cast<float>(share) * (mixed[i].position[k] - older.grains[i].position[k]);
    return mixed;
  }
};

struct Phone {
  const Case& run;
  double ns = 0, longest_ns = 0, frame_factor = 1, known_factor = 1;
  Noise units{1}, frames{20}, budgets{99};
  Governor* governor = nullptr;
  std::vector<Governor::Kind> assumed = {};

  double factor() const {
    const double s = ns * 1e-9, up = run.seconds * 5 / 7;
    switch (run.clock) {
      case Clock::spans_of_2s:
        return std::fmod(s, 4.0) < 2 ? 1 : std::fmod(s, 8.0) < 4 ? 3 : 4;
      case Clock::spans_of_quarter:
        return std::fmod(s, 0.5) < 0.25 ? 1 : std::fmod(s, 1.0) < 0.5 ? 3 : 4;
      case Clock::heat:
        return std::pow(7.0, s < up ? s / up : std::max(0.0, 1 - (s - up) / (run.seconds - up) * 1.25));
      default:
        return frame_factor;
    }
  }
  uint64_t begin_frame(uint64_t frame, double start_ns) {
    ns = std::max(ns, start_ns);
    longest_ns = 0;
    if (run.clock == Clock::slow_frames) frame_factor = frames.uniform() < 0.05 ? 4 : 1;
    if (run.clock == Clock::cold) frame_factor = frame < 10 ? 3 : 1;
    for (Governor::Kind& kind : governor->kinds) {
      if (run.speed == Speed::given) scale(&kind, factor() / known_factor);
      if (run.speed == Speed::assumed && frame == 100) assumed.push_back(kind);
    }
    known_factor = factor();
    return static_cast<uint64_t>(1e6 * (run.budget_ms > 0 ? run.budget_ms : 1 + 5 * budgets.uniform()));
  }
  static void scale(Governor::Kind* kind, double by) {
    for (uint64_t& cost : kind->recent) cost = static_cast<uint64_t>(static_cast<double>(cost) * by);
    kind->estimate = static_cast<uint64_t>(static_cast<double>(kind->estimate) * by);
  }
  void ran(const WorkUnit& unit) {
    const double counted = host::unit_instructions(unit.name, unit.items);
    double cost = (counted > 0 ? counted : 20'000) / run.core * std::exp(0.12 * units.normal()) * factor();
    if (units.uniform() < 0.005) cost *= 2;
    ns += cost;
    longest_ns = std::max(longest_ns, cost);
    if (unit.kind < assumed.size()) governor->kinds[unit.kind] = assumed[unit.kind];
  }
};

// A tray of sand under a hand that stirs, as the phone runs it.
struct Stirred {
  const double hz;
  std::vector<sandglass_collider> tray;
  Scene scene;
  PileShadow shadow;
  Skin skin;
  Positions written;
  sandglass_frame_input input = frame_input();
  sandglass_frame_report report = frame_report();

  Stirred(const Case& run, Phone* phone) : hz(run.budget_ms == 2.0 ? 120 : 60) {
    create(run, phone);
    put_tray();
    input.time_step = static_cast<float>(1 / hz);
    input.colliders = tray.data();
    input.collider_count = static_cast<uint32_t>(tray.size());
    input.grains = run.skin ? nullptr : written.data();
    input.grain_capacity = static_cast<uint32_t>(written.size());
    input.pile_shadow = shadow.get();
    input.skin = run.skin ? skin.get() : nullptr;
  }
  void create(const Case& run, Phone* phone) {
    constexpr float k_radius = 0.01f, k_edge = 0.0068f;
    std::vector<float> particles, grains;
    const Box box{{-0.10f, k_radius, -0.10f}, {0.10f, 0.21f, 0.10f}};
    EXPECT_TRUE(sample_lattice(
        box, 2.02f * k_radius, [](const float*) { return true; }, &particles));
    uint32_t random = 1;
    for (float y = k_radius; !run.skin && y < 0.21f; y += k_edge)
      for (float z = -0.1f; z < 0.1f; z += k_edge)
        for (float x = -0.1f; x < 0.1f; x += k_edge)
          for (const float at : {x, y, z}) {
            random = random * 1664525u + 1013904223u;
            grains.push_back(at + 0.5f * k_edge * static_cast<float>(random >> 8) / 16777216.0f);
          }
    written.resize(grains.size() / 3);
    sandglass_scene_desc desc = scene_desc();
    desc.clock = {[](void* user) { return static_cast<uint64_t>(static_cast<Phone*>(user)->ns); }, phone};
    desc.granular.particle_radius = k_radius;
    desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3);
    desc.granular.grain_capacity = static_cast<uint32_t>(written.size());
    desc.granular.collider_capacity = 8;
    sandglass_pile_shadow_desc of_shadow = pile_shadow_desc();
    of_shadow.texels = 128;
    of_shadow.sky_texels = 64;
    of_shadow.on_sand = 0;
    std::fill_n(of_shadow.low, 2, -0.64f);
    std::fill_n(of_shadow.high, 2, 0.64f);
    EXPECT_TRUE(scene.create(desc) && scene.add(particles, grains) && shadow.create(of_shadow));
    EXPECT_TRUE(shadow.set_light({0.5f, 0.7f, 0.2f}));
    EXPECT_TRUE(!run.skin || skin.create(skin_desc(desc.granular)));
    Governor* governor = phone->governor = &scene.get()->governor;
    governor->observer = {[](void* user, const WorkUnit& unit) { static_cast<Phone*>(user)->ran(unit); }, phone};
    governor->policy.better_after = run.better_after;
  }
  // A floor, four walls, and the hand.
  void put_tray() {
    tray = {floor_at(0.0f)};
    for (int side = 0; side < 4; ++side) {
      sandglass_collider wall = floor_at(0.0f);
      wall.shape = SANDGLASS_SHAPE_BOX;
      wall.position[side / 2 * 2] = side % 2 ? 0.19f : -0.19f;
      wall.position[1] = 0.05f;
      wall.size[side / 2 * 2] = 0.03f;
      wall.size[1] = 0.06f;
      wall.size[2 - side / 2 * 2] = 0.25f;
      tray.push_back(wall);
    }
    tray.push_back(sphere(0.0f, 0.05f, 0.0f, 0.04f));
  }
  void stir(uint64_t frame) {
    const double turn = k_pi * static_cast<double>(frame + 1) / hz;
    const float sine = static_cast<float>(0.11 * std::sin(turn)), cosine = static_cast<float>(0.11 * std::cos(turn));
    sandglass_collider& hand = tray.back();
    hand.position[0] = cosine;
    hand.position[1] = 0.045f;
    hand.position[2] = sine;
    hand.linear_velocity[0] = -static_cast<float>(k_pi) * sine;
    hand.linear_velocity[2] = static_cast<float>(k_pi) * cosine;
  }
  uint32_t skin_version() const {
    sandglass_skin_mesh mesh = {};
    mesh.struct_size = sizeof mesh;
    if (input.skin != nullptr) sandglass_skin_get_mesh(skin.get(), &mesh);
    return mesh.version;
  }
};

Seen see(const Case& run) {
  Phone phone{run};
  Stirred stirred(run, &phone);
  const auto moves = [&](double now, double before) { return (now - before) * stirred.hz >= 0.05; };
  Positions some(stirred.written.size() / 7);
  Seen seen = {};
  Jerk even, as_written;
  App app;
  double drawn = 0, reached = 0;
  uint32_t level = 0, skins = 0;
  const uint64_t frames = static_cast<uint64_t>(run.seconds * stirred.hz);
  for (uint64_t f = 0; f < frames; ++f) {
    stirred.stir(f);
    stirred.input.budget_ns = phone.begin_frame(f, static_cast<double>(f) / stirred.hz * 1e9);
    const double start = phone.ns;
    EXPECT_TRUE(stirred.scene.frame(stirred.input, &stirred.report));

    const double over = phone.ns - start - static_cast<double>(stirred.input.budget_ns);
    seen.late_percent += over > 0;
    seen.late_by_more_percent += over > phone.longest_ns + 1000;
    seen.levels += f != 0 && stirred.report.level != level;
    level = stirred.report.level;
    const uint32_t skin = stirred.skin_version();
    seen.new_skins_percent += skin != skins;
    skins = skin;

    const sandglass_sand_report& sand = stirred.report.sand;
    for (size_t i = 0; i < some.size(); ++i) some[i] = stirred.written[7 * i];
    even.add(app.draw(some, sand));
    as_written.add(some);
    seen.even.frozen_percent += f >= 2 && !moves(app.drawn, drawn);
    seen.written.frozen_percent += f >= 2 && !moves(sand.grains_time, reached);
    drawn = app.drawn;
    reached = sand.grains_time;
    seen.behind_ms += 1e3 * (reached - drawn);
  }
  seen.even.jerk_mm = even.mm();
  seen.written.jerk_mm = as_written.mm();
  for (double* count : {&seen.even.frozen_percent, &seen.written.frozen_percent, &seen.late_percent,
                        &seen.late_by_more_percent, &seen.new_skins_percent})
    *count *= 100 / static_cast<double>(frames);
  seen.behind_ms /= static_cast<double>(frames);
  seen.levels /= run.seconds;
  seen.lost_percent = 100 * stirred.report.time.debt / run.seconds;
  return seen;
}

std::string text(const Seen& s) {
  char line[256];
  std::snprintf(
      line, sizeof line,
      "frozen %.1f %% (written %.1f), jerk %.2f mm (%.2f), behind %.1f ms, late %.2f %% (%.2f), levels %.2f a second, "
      "lost %.1f %%",
      s.even.frozen_percent, s.written.frozen_percent, s.even.jerk_mm, s.written.jerk_mm, s.behind_ms,
      s.late_by_more_percent, s.late_percent, s.levels, s.lost_percent);
  return line;
}

// The bars of each scenario: percent of frames that are frozen, and late by more than a work unit; level changes a second.
// Then the same without grains, where the particles' skin is drawn: it stands where it is neither new nor carried along.
//
// Where costs rise within a frame, the output takes more than the reserve, which was estimated before the rise.
TEST(UnsteadyClock, WhatIsDrawnMovesInEachFrameAndNoneIsLate) {
  if (!k_runs) GTEST_SKIP();
  const struct {
    const char* name;
    Case run;
    double frozen, late, levels;
  } rows[] = {
      {"steady, 120 Hz, 2 ms", {Clock::steady, 2, 2}, 7, 0.35, 3},
      {"steady, 4 ms", {Clock::steady, 4, 3}, 7, 0.35, 3},
      {"steady, 8 ms", {Clock::steady, 8, 2}, 7, 0.35, 3},
      {"small core, 120 Hz, 2 ms", {Clock::steady, 2, 2, k_a78}, 7, 0.35, 3},
      {"small core, 4 ms", {Clock::steady, 4, 3, k_a78}, 7, 0.35, 3},
      {"small core, 8 ms", {Clock::steady, 8, 3, k_a78}, 7, 0.35, 3},
      {"3 to 4 times every 2 s, 4 ms", {Clock::spans_of_2s, 4, 8}, 11, 0.35, 99},
      {"3 to 4 times every 2 s, 8 ms", {Clock::spans_of_2s, 8, 4}, 7, 0.35, 99},
      {"3 to 4 times every 0.25 s, 120 Hz, 2 ms", {Clock::spans_of_quarter, 2, 2}, 28, 1.6, 99},
      {"3 to 4 times every 0.25 s, 4 ms", {Clock::spans_of_quarter, 4, 3}, 28, 1.6, 99},
      {"3 to 4 times every 0.25 s, 8 ms", {Clock::spans_of_quarter, 8, 8}, 8, 1.6, 99},
      {"4 times in one frame of 20, 120 Hz, 2 ms", {Clock::slow_frames, 2, 2}, 7, 3.9, 99},
      {"4 times in one frame of 20, 4 ms", {Clock::slow_frames, 4, 4}, 7, 3.9, 99},
      {"cold, 4 ms", {Clock::cold, 4, 2}, 7, 0.35, 99},
      {"1 to 6 ms at random", {Clock::steady, 0, 3}, 7, 0.35, 99},
      {"heat, 4 ms", {Clock::heat, 4, 7}, 11, 0.35, 99},
  };
  for (const auto& row : rows) {
    const Seen seen = see(row.run);
    std::printf("%-40s %s\n", row.name, text(seen).c_str());
    SCOPED_TRACE(row.name);
    EXPECT_LE(seen.even.frozen_percent, row.frozen);
    EXPECT_LE(seen.late_by_more_percent, row.late);
    EXPECT_LE(seen.levels, row.levels);
    Case of_skin = row.run;
    of_skin.skin = true;
    const Seen skin = see(of_skin);
    std::printf("%-40s frozen %.1f %%, late %.2f %%, levels %.2f a second, lost %.1f %%\n", "  its skin",
                100 - skin.new_skins_percent, skin.late_by_more_percent, skin.levels, skin.lost_percent);
    EXPECT_LE(100 - skin.new_skins_percent, row.frozen);
    EXPECT_LE(skin.late_by_more_percent, row.late);
    EXPECT_LE(skin.levels, row.levels);
  }
}

TEST(UnsteadyClock, DrawnAsWrittenGrainsStandInEveryOtherFrame) {
  if (!k_runs) GTEST_SKIP();
  const Seen seen = see({Clock::steady, 4, 3, k_a78});
  EXPECT_LE(seen.even.jerk_mm, 0.65 * seen.written.jerk_mm);
  EXPECT_LE(seen.behind_ms, 20);
  EXPECT_GE(seen.written.frozen_percent, 50) << "the control";
}

TEST(UnsteadyClock, ALevelThatIsTakenAtOnceFlickers) {
  if (!k_runs) GTEST_SKIP();
  EXPECT_GE(see({Clock::steady, 8, 2, k_a78, Speed::learned, 1}).levels, 3 * 3) << "the control: three times the bar";
}

TEST(UnsteadyClock, NoTimeIsLostThatAToldGovernorWouldKeep) {
  if (!k_runs) GTEST_SKIP();
  for (const Clock clock : {Clock::spans_of_2s, Clock::spans_of_quarter}) {
    const double learned = see({clock, 4, 4}).lost_percent, given = see({clock, 4, 4, k_x3, Speed::given}).lost_percent;
    std::printf("lost %.2f %%, told %.2f\n", learned, given);
    EXPECT_LE(learned, given + 2);
  }
  EXPECT_LE(see({Clock::spans_of_2s, 4, 4}).late_percent, 1);
  EXPECT_GE(see({Clock::spans_of_2s, 4, 4, k_x3, Speed::assumed}).late_percent, 10) << "the control";
}

TEST(ShownTime, IsThatOfTheGrainsAtFullRate) {
  GranularScene scene(description(64, 512));
  scene.add_floor();
  const std::vector<float> particles = lattice(4, 4, 4, 0.0202f, 0.0102f);
  scene.add(particles, {}, grains_about(particles, 0.005f));
  for (int f = 0; f < 200; ++f) {
    const sandglass_frame_report report = scene.frame(f % 10 == 9 ? 0.0f : 0.004f * static_cast<float>(1 + f % 7));
    EXPECT_NEAR(report.sand.grains_time, report.time.simulated, 1e-6);
    EXPECT_EQ(report.sand.shown_time, report.sand.grains_time) << f;
  }
}

// Each of its units takes 0.1 ms: it slows down.
TEST(ShownTime, IsSavedAndReplayed) {
  VirtualClock clock;
  clock.step_ns = 100000;
  sandglass_scene_desc desc = description(64, 512);
  desc.clock = virtual_clock(&clock);
  GranularScene first(desc), second(desc), replay(desc);
  const std::vector<float> particles = lattice(4, 4, 4, 0.0202f, 0.0102f);
  for (GranularScene* scene : {&first, &second, &replay}) {
    scene->add_floor();
    scene->add(particles, {}, grains_about(particles, 0.005f));
  }
  const auto same = [](const sandglass_frame_report& a, const sandglass_frame_report& b) {
    EXPECT_EQ(a.sand.grains_time, b.sand.grains_time);
    EXPECT_EQ(a.sand.shown_time, b.sand.shown_time);
  };
  double behind = 0;
  for (int f = 0; f < 60; ++f) {
    const sandglass_frame_report report = first.frame(0.02f, 2000000);
    same(report, replay.frame(0.02f, 0, &report.plan));
    behind = std::max(behind, report.sand.grains_time - report.sand.shown_time);
  }
  EXPECT_GT(behind, 0.01);
  std::vector<std::byte> bytes;
  ASSERT_TRUE(first.scene.save(&bytes) && second.scene.restore(bytes));
  for (int f = 0; f < 20; ++f) same(first.frame(0.02f), second.frame(0.02f));
}

}  // namespace
}  // namespace sandglass::governor_test
