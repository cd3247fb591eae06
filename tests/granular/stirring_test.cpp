// A hand stirs sand in a glass box for hours, and everything that a frame can do is on: a nozzle pours, a drain
// swallows, the shadows of an object and of the sand follow a light that turns, a camera looks around the room, the
// network estimates its light, and budget, heat and the cost of work units vary. After every frame what must hold of
// any scene does (invariants.h), and the sand is between the walls. In every stretch each stage works.
//
// A stretch is 1,000 frames. It begins with new objects, restored from what the one before saved, and with random
// numbers of its own. So
//
//   SANDGLASS_STIRRING_FRAMES=1000000 SANDGLASS_STIRRING_STATE=state sandglass_stirring_tests
//
// goes on where it was interrupted, and begins with the stretch that failed where one did. A million frames are four
// and a half hours of stirring.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "runtime/core/random.h"
#include "tests/granular/granular_scene.h"
#include "tests/granular/invariants.h"
#include "tests/lighting/light_fixture.h"
#include "tests/peak_memory.h"
#include "tests/shadow/shadow_fixture.h"

namespace sandglass::tests {
namespace {

constexpr uint64_t k_stretch = 1000;
constexpr float k_r = 0.01f, k_wall = 0.1f, k_frame = 1.0f / 60.0f;
constexpr uint32_t k_particles = 500, k_first = 300, k_grains_each = 8, k_fingers = 3;
constexpr uint32_t k_width = 64, k_height = 48;

// What a stretch leaves behind.
struct Saved {
  uint64_t stretches = 0, hash = 0;
  double asked = 0.0;
  std::vector<std::byte> scene, room;
};

class Stretch : public WatchedScene {
 public:
  Stretch(const Saved& before, sandglass_isa isa)
      : number_(before.stretches),
        random_(random_stream(number_, 11)),
        cost_random_(random_stream(number_, 12)),
        shadow_(describe(shadow_file(), isa)),
        pixels_(3 * size_t{k_width} * k_height) {
    describe_scene(isa);
    block = test::GuardedBlock(Scene::bytes(desc));
    ::accept(scene.create_in(desc, block.data(), block.bytes()));
    drawn = test::GuardedBlock(sizeof(sandglass_grain) * desc.granular.grain_capacity);
    create_light_and_shadows(isa);
    add_colliders();
    particles_added = k_first, grains_added = k_first * k_grains_each;
    if (before.scene.empty()) {
      add_sand();
    } else {
      ::accept(scene.restore(before.scene));
      ::accept(room_.restore(before.room));
      asked = before.asked;
    }
  }

  // Says what was wrong first; empty: nothing.
  std::string run(uint64_t frames) {
    Invariants invariants(*this);
    uint64_t units[SANDGLASS_STAGE_COUNT] = {};
    for (uint64_t frame = 0; frame < frames; ++frame) {
      const sandglass_frame_input input = next_input(frame);
      sandglass_frame_report report = frame_report();
      const Status status = scene.frame(input, &report);
      std::string what = status ? invariants.broken(report) : status.reason;
      if (what.empty() && !shadow_.block.guards_intact()) what = "a byte outside the shadow's block was touched";
      const sandglass_sand_report& sand = report.sand;
      const uint32_t ignored = sand.ignored_colliders + sand.ignored_emitters + sand.ignored_sinks;
      if (what.empty() && ignored + report.estimate.ignored_images != 0) what = "something was left out";
      if (what.empty()) what = outside(report);
      if (!what.empty()) return "frame " + std::to_string(frame) + ": " + what;
      for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) units[stage] += report.stages[stage].units;
    }
    for (uint32_t stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
      if (units[stage] == 0) return "no work in stage " + std::to_string(stage);
    return "";
  }

  Saved leave() {
    Saved after = {number_ + 1, scene.hash(), asked, {}, {}};
    ::accept(scene.save(&after.scene));
    ::accept(room_.save(&after.room));
    return after;
  }

 private:
  float between(double low, double high) { return static_cast<float>(low + (high - low) * random_.uniform()); }

  static const AssetFile& shadow_file() {
    RandomShadow what;
    what.version = 2, what.ambient_side = 16, what.components = 24;
    static const AssetFile file = make_shadow_file(what);
    return file;
  }

  void describe_scene(sandglass_isa isa) {
    desc = scene_desc();
    desc.isa = isa;
    desc.granular.particle_radius = k_r;
    desc.granular.particle_capacity = k_particles, desc.granular.grain_capacity = k_particles * k_grains_each;
    desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
    desc.granular.collider_capacity = k_fingers + 5;
    desc.clock = {now, this}, desc.trace = {unit_begins, unit_ends, this};
  }

  void create_light_and_shadows(sandglass_isa isa) {
    sandglass_estimator_desc light = describe_light();
    light.isa = isa, light.interval = 8.0f;  // two estimates in a stretch
    ::accept(light_.create(light));
    ::accept(room_.create());
    sandglass_pile_shadow_desc pile = pile_shadow_desc();
    pile.isa = isa, pile.texels = 32, pile.sky_texels = 32, pile.on_sand = 1;
    for (int k = 0; k < 2; ++k) pile.low[k] = -k_wall, pile.high[k] = k_wall;
    ::accept(pile_.create(pile));
    image_ = camera_image();
    image_.width = k_width, image_.height = k_height;
    image_.planes[0] = pixels_.data(), image_.strides[0] = 3 * k_width;
    image_.focal_x = image_.focal_y = sandglass_camera_focal(k_width, k_height, 80);
    image_.centre_x = 0.5f * (k_width - 1), image_.centre_y = 0.5f * (k_height - 1);
    image_.exposure = 1.0f;
  }

  // The fingers first, so that walls and floor, which come last, win.
  void add_colliders() {
    for (uint32_t i = 0; i < k_fingers; ++i) colliders_.push_back(capsule(0, 0, 0, 0.8f * k_r, 3 * k_r));
    for (int k = 0; k < 4; ++k) {
      const float x = k == 0 ? k_wall : k == 1 ? -k_wall : 0, z = k == 2 ? k_wall : k == 3 ? -k_wall : 0;
      sandglass_collider wall = collider(SANDGLASS_SHAPE_HALF_SPACE, x, 0, z);
      // Its free side is along local y: turned to the middle.
      const Rotation turn = k < 2 ? rotation_about(0, 0, 1, (k == 0 ? 0.5f : -0.5f) * k_pi)
                                  : rotation_about(1, 0, 0, (k == 2 ? -0.5f : 0.5f) * k_pi);
      std::copy(turn.begin(), turn.end(), wall.rotation);
      colliders_.push_back(wall);
    }
    colliders_.push_back(floor_at(0.0f));
    for (uint32_t k = 0; k < 3; ++k) rate_[k] = between(1, 6), phase_[k] = between(0, 6);
    spin_ = between(-4, 4);
  }

  void add_sand() {
    std::vector<float> particles, grains;
    for (uint32_t i = 0; i < k_first; ++i) {
      const uint32_t place[3] = {i % 8, i / 64, i / 8 % 8};
      float p[3];
      for (uint32_t k = 0; k < 3; ++k)
        p[k] = 2.1f * k_r * (static_cast<float>(place[k]) - (k == 1 ? -0.6f : 3.5f)) + k_r * between(0, 0.05);
      particles.insert(particles.end(), p, p + 3);
      for (uint32_t g = 0; g < k_grains_each; ++g)
        for (const float v : p) grains.push_back(v + k_r * between(-0.5, 0.5));
    }
    ::accept(scene.add(particles, grains));
  }

  // The hand's middle swings with three rates, and the fingers turn about it; now and then it is somewhere else at once.
  void move_hand(float time) {
    if (random_.below(400) == 0)
      for (uint32_t k = 0; k < 3; ++k) rate_[k] = between(1, 6), phase_[k] = between(0, 6);
    const float swing[3] = {0.06f, 0.05f, 0.06f}, middle[3] = {0.0f, 0.09f, 0.0f};
    for (uint32_t i = 0; i < k_fingers; ++i) {
      sandglass_collider& finger = colliders_[i];
      const float angle = spin_ * time + 2 * k_pi * static_cast<float>(i) / k_fingers, reach = 2.5f * k_r;
      const float arm[3] = {reach * std::cos(angle), 0, -reach * std::sin(angle)};
      const float turning[3] = {spin_ * arm[2], 0, -spin_ * arm[0]};
      for (uint32_t k = 0; k < 3; ++k) {
        const float at = rate_[k] * time + phase_[k];
        finger.position[k] = middle[k] + swing[k] * std::sin(at) + arm[k];
        finger.linear_velocity[k] = swing[k] * rate_[k] * std::cos(at) + turning[k];
      }
      const Rotation turn = rotation_about(0, 1, 0, angle);
      std::copy(turn.begin(), turn.end(), finger.rotation);
      finger.angular_velocity[1] = spin_;
    }
  }

  void look_around(float time) {
    const uint32_t brightness = 40 + random_.below(160);
    for (uint8_t& p : pixels_) p = static_cast<uint8_t>(brightness + random_.below(56));
    const Rotation pose = rotation_about(0.3f * std::sin(0.7f * time), 1, 0, 1.3f * time);
    std::copy(pose.begin(), pose.end(), image_.orientation);
    image_.timestamp_ns += 16'666'667;
  }

  void turn_lights(float time) {
    const std::array<float, 3> sun = {std::cos(time), 0.8f, std::sin(time)};
    shadow_.light(sun[0], sun[1], sun[2]);
    ::accept(pile_.set_light(sun));
    const float place[3] = {0, 0.05f, 0};
    const sandglass_room_light seen = room_.light_at(place);
    ::accept(pile_.set_cells(seen.cells));
    const char* reason = nullptr;
    if (sandglass_shadow_set_cells(shadow_.shadow, seen.cells, time, &reason) != SANDGLASS_OK)
      throw std::runtime_error(reason);
  }

  sandglass_frame_input next_input(uint64_t frame) {
    const float time = k_frame * static_cast<float>(frame);
    move_hand(time), look_around(time);
    if (frame % 10 == 0) turn_lights(time);
    if (frame % 50 == 0) unit_ns_ = 10'000 + random_.below(60'000);
    sandglass_frame_input input = frame_input();
    input.time_step = k_frame;
    asked += static_cast<double>(k_frame);
    input.budget_ns = random_.below(100) == 0 ? 0 : 2'000'000 + random_.below(14'000'000);
    input.thermal_headroom = frame / 100 % 3 == 0 ? between(0.3, 1) : 1.0f;
    input.output_lag = frame / 100 % 4 == 0 ? 0.02f : 0.0f;
    input.colliders = colliders_.data(), input.collider_count = static_cast<uint32_t>(colliders_.size());
    input.emitters = &nozzle_, input.emitter_count = frame / 120 % 3 == 0 ? 1 : 0;
    input.sinks = &drain_, input.sink_count = 1;
    input.grains = reinterpret_cast<sandglass_grain*>(drawn.data());
    input.grain_capacity = desc.granular.grain_capacity;
    input.shadows = &shadow_.shadow, input.shadow_count = 1;
    input.pile_shadow = pile_.get(), input.estimator = light_.get(), input.room = room_.get(), input.camera = &image_;
    return input;
  }

  // What a wall lets through, were it only a rounding.
  std::string outside(const sandglass_frame_report& report) {
    positions_.resize(3ull * report.sand.particle_numbers);
    sandglass_granular_particles(scene.get(), positions_.data(), nullptr);
    for (uint32_t i = 0; i < report.sand.particle_numbers; ++i) {
      const float* p = &positions_[3 * size_t{i}];
      if (p[1] == SANDGLASS_REMOVED_Y) continue;
      if (std::max(std::fabs(p[0]), std::fabs(p[2])) > k_wall - k_r * (1.0f - 1e-3f))
        return "particle " + std::to_string(i) + " is in a wall, at x = " + std::to_string(p[0]) +
               " m, z = " + std::to_string(p[2]) + " m";
    }
    return "";
  }

  static uint64_t now(void* user) { return static_cast<Stretch*>(user)->clock_ns_; }
  static void unit_begins(void*, const char*) {}
  static void unit_ends(void* user, const char*) {
    Stretch* s = static_cast<Stretch*>(user);
    s->clock_ns_ += s->unit_ns_ * (50 + s->cost_random_.below(100)) / 100;
  }

  static constexpr float k_pi = 3.14159265f;
  uint64_t number_;
  Random random_, cost_random_;
  uint64_t clock_ns_ = 0, unit_ns_ = 30'000;
  LiveShadow shadow_;
  PileShadow pile_;
  Estimator light_;
  Room room_;
  std::vector<uint8_t> pixels_;
  sandglass_camera_image image_ = {};
  std::vector<sandglass_collider> colliders_;
  sandglass_emitter nozzle_ = emitter(0, 0.7f, 0, 3 * k_r, 0.6f, k_grains_each);
  sandglass_collider drain_ = box(0.07f, 0, 0.07f, 0.03f, 0.02f, 0.03f);
  float rate_[3] = {}, phase_[3] = {}, spin_ = 0;
  std::vector<float> positions_;
};

// Runs the stretch that follows. Throws what was wrong.
Saved follow(const Saved& before, uint64_t frames, sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC) {
  Stretch stretch(before, isa);
  const std::string what = stretch.run(frames);
  if (!what.empty()) throw std::runtime_error("stretch " + std::to_string(before.stretches) + ", " + what);
  return stretch.leave();
}

template <class T>
void write(std::ofstream& file, const T* values, size_t count) {
  file.write(reinterpret_cast<const char*>(values), static_cast<std::streamsize>(count * sizeof(T)));
}

void write_state(const std::filesystem::path& path, const Saved& saved) {
  const std::filesystem::path unfinished = path.string() + ".part";
  {
    std::ofstream file(unfinished, std::ios::binary);
    const uint64_t numbers[4] = {saved.stretches, saved.hash, saved.scene.size(), saved.room.size()};
    write(file, numbers, 4), write(file, &saved.asked, 1);
    write(file, saved.scene.data(), saved.scene.size()), write(file, saved.room.data(), saved.room.size());
    file.flush();
    if (!file) throw std::runtime_error("the state cannot be written");
  }
  std::filesystem::rename(unfinished, path);
}

Saved read_state(const std::filesystem::path& path) {
  Saved saved;
  if (!std::filesystem::exists(path)) return saved;
  std::ifstream file(path, std::ios::binary);
  uint64_t numbers[4] = {};
  file.read(reinterpret_cast<char*>(numbers), sizeof numbers);
  file.read(reinterpret_cast<char*>(&saved.asked), sizeof saved.asked);
  if (!file || numbers[2] + numbers[3] > std::filesystem::file_size(path)) throw std::runtime_error("no state's file");
  saved.stretches = numbers[0], saved.hash = numbers[1];
  saved.scene.resize(numbers[2]), saved.room.resize(numbers[3]);
  file.read(reinterpret_cast<char*>(saved.scene.data()), static_cast<std::streamsize>(numbers[2]));
  file.read(reinterpret_cast<char*>(saved.room.data()), static_cast<std::streamsize>(numbers[3]));
  return saved;
}

TEST(Stirring, EverythingHoldsInEveryFrame) {
  const char *wanted = std::getenv("SANDGLASS_STIRRING_FRAMES"), *path = std::getenv("SANDGLASS_STIRRING_STATE");
  if (wanted == nullptr) {
    // In an ordinary run: a short stretch, and the next one from what it saved.
    Saved saved;
    ASSERT_NO_THROW(saved = follow({}, 150));
    ASSERT_NO_THROW(saved = follow(saved, 150));
    return;
  }
  const uint64_t stretches = std::strtoull(wanted, nullptr, 10) / k_stretch;
  Saved saved = path == nullptr ? Saved() : read_state(path);
  int64_t memory = 0;
  for (uint64_t done = 0; saved.stretches < stretches; ++done) {
    const Saved before = saved;
    try {
      saved = follow(before, k_stretch);
      // Now and then on the scalar kernels as well: the same bits.
      if (before.stretches % 50 == 0 && follow(before, k_stretch, SANDGLASS_ISA_SCALAR).hash != saved.hash)
        throw std::runtime_error("stretch " + std::to_string(before.stretches) + " differs on the scalar kernels");
    } catch (const std::exception& wrong) {
      FAIL() << wrong.what();
    }
    if (path != nullptr) write_state(path, saved);
    if (done == 10) memory = peak_memory_kib();
    if (done > 10) {
      ASSERT_LE(peak_memory_kib(), memory + 1024) << "KiB: memory grows";
    }
    std::printf("%llu000 frames, hash 0x%016llx\n", static_cast<unsigned long long>(saved.stretches),
                static_cast<unsigned long long>(saved.hash));
    std::fflush(stdout);
  }
}

// What a stretch does follows from what it is given alone, on any kernels.
TEST(Stirring, AStretchIsRepeatedToTheBit) {
  const Saved first = follow({}, 60);
  const Saved here = follow(first, 60), again = follow(first, 60, SANDGLASS_ISA_SCALAR);
  EXPECT_EQ(here.hash, again.hash);
  EXPECT_EQ(here.scene, again.scene);
  EXPECT_EQ(here.room, again.room);
  EXPECT_NE(here.hash, first.hash);
}

}  // namespace
}  // namespace sandglass::tests
