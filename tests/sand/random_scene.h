// A whole scene drawn from one number: the material, the colliders, what moves, pours and drains, the shadows, the light,
// the room and the relief, the clock and its budgets, the pool, and what an app does between frames. The same number gives the same
// scene and the same inputs, frame by frame, on any machine. Every eighth has all stages, every hundredth a thousand
// frames.
//
// Two things are alike in all of them, so that a test can say where sand must be: a floor at y = 0 is the last of the
// colliders and does not move, and everything starts above it.
#pragma once

#include <optional>
#include <vector>

#include "runtime/math/random.h"
#include "sandglass/sandglass.hpp"
#include "tests/guarded_block.h"
#include "tests/shadow/shadow_fixture.h"

namespace sandglass::tests {

struct RandomScene {
  // How a run differs from the recorded one: its plans are given, so no clock is asked; other kernels; no pool.
  explicit RandomScene(uint64_t number, bool replays = false);

  // What the frame is given. It draws on, and does what the app does between frames: call it once a frame.
  sandglass_frame_input next_input();
  // Of all that the frames change.
  uint64_t hash() const;

  // What a test knows about it. The floor is the last of its colliders.
  // Sand and bodies that the app has put into the scene. Emitters and sinks are in the reports.
  uint64_t particles_added = 0, grains_added = 0;
  // Seconds that the frames so far have asked for, as the library counts them.
  double asked = 0.0;
  // Numbers of particles from which those of bodies begin; bodies are added first, so they are below it.
  uint32_t in_bodies = 0;
  // A collider that only grains see comes after the floor, and may push grains below it.
  bool grains_have_floor = true;
  // A rigid body that another collider presses into the floor cannot obey both.
  bool bodies_have_floor = true;

  sandglass_scene_desc desc;
  Scene scene;
  test::GuardedBlock block{0}, drawn{0};
  uint32_t frames;
  std::optional<LiveShadow> shadow;

 private:
  float between(double low, double high) { return static_cast<float>(low + (high - low) * random_.uniform()); }
  float log_between(double low, double high);
  bool one_in(uint32_t n) { return random_.below(n) == 0; }
  void describe(bool replays);
  void add_bodies();
  void add_sand(uint32_t count_max);
  void add_colliders();
  void add_shadows();
  void add_light();
  void add_relief();
  void move_colliders(float step);
  void act();
  float draw_step();

  static uint64_t now(void* user);
  static void pool(void* user, sandglass_task_function task, void* context, uint32_t count);
  static void unit_begins(void*, const char*) {}
  static void unit_ends(void* user, const char*);

  Random random_, clock_random_, pool_random_, light_random_, depth_random_;
  bool every_stage_;  // of every eighth scene
  uint64_t clock_ns_ = 0, unit_ns_ = 0;
  uint32_t clock_kind_ = 0;
  float r_ = 0.01f, height_ = 0.0f;  // the radius; where the next sand starts
  struct Motion {
    float amplitude[3], rate, phase, start[3];
  };
  Field field_;
  std::vector<sandglass_collider> colliders_, sinks_;
  std::vector<Motion> motions_;
  std::vector<sandglass_emitter> emitters_;
  PileShadow pile_;
  Skin skin_;
  Estimator light_;
  Room room_;
  std::vector<uint8_t> pixels_;
  sandglass_camera_image image_ = {};
  Relief relief_;
  std::vector<uint16_t> depths_;
  sandglass_depth_image depth_ = depth_image();
  double time_ = 0.0;
};

}  // namespace sandglass::tests
