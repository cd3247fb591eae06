// A small granular scene for tests: owns what its frames are given and its grain buffer, and steps by whole frames. A call
// that the library refuses throws the library's reason.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <vector>

#include "sandglass/sandglass.hpp"

// Throws the reason of a call that was refused.
void accept(const sandglass::Status& status);

struct GranularScene {
  explicit GranularScene(const sandglass_scene_desc& desc) { accept(scene.create(desc)); }

  void add(const std::vector<float>& particles, const std::vector<float>& velocities = {},
           const std::vector<float>& grains = {}, const std::vector<float>& grain_velocities = {});
  // Returns the body's number.
  uint32_t add_body(const std::vector<float>& points, float density = 1.0f,
                    std::initializer_list<float> velocity = {0, 0, 0}, std::initializer_list<float> spin = {0, 0, 0});
  void add_floor(float height = 0.0f) { colliders.push_back(sandglass::floor_at(height)); }
  // Four upright ones, between which sand has room from x and z of `low` to those of `high`.
  void add_walls(std::array<float, 2> low, std::array<float, 2> high);

  // What this scene has, with a budget that is unlimited unless said otherwise.
  sandglass_frame_input input(float time_step, uint64_t budget_ns = ~0ull >> 1, const sandglass_plan* plan = nullptr);
  sandglass_frame_report run(const sandglass_frame_input& input);
  sandglass_frame_report frame(float time_step, uint64_t budget_ns = ~0ull >> 1, const sandglass_plan* plan = nullptr) {
    return run(input(time_step, budget_ns, plan));
  }

  std::vector<float> positions() const;
  std::vector<float> velocities() const;
  uint64_t hash() const { return scene.hash(); }

  sandglass::Scene scene;
  std::vector<sandglass_collider> colliders, sinks;
  std::vector<sandglass_emitter> emitters;
  std::vector<sandglass_grain> grains;
  bool draws = true;  // frames write the grains
  uint32_t particle_count = 0;
};

// Frames until all sand sleeps; the last one's report. Throws after 500 frames.
sandglass_frame_report until_asleep(GranularScene* scene, float time_step = 0.02f);

// The defaults with room for this much, without a clock: every frame does all of its work.
sandglass_scene_desc description(uint32_t particles, uint32_t grains = 0, uint32_t boundary = 0);
// With room for so many bodies, of so many particles together, and for a sink.
sandglass_scene_desc with_bodies(uint32_t sand, uint32_t bodies, uint32_t in_bodies);

// A block of a cubic lattice standing on y = r: x * y * z particles at the given spacing, every other layer shifted by
// a quarter of it so that columns do not balance on their tips.
std::vector<float> lattice(uint32_t x, uint32_t y, uint32_t z, float spacing, float radius);
// The points of a loose lattice in the box, for particles of 1 cm, wherever `room` has space for one.
std::vector<float> loose_points(const sandglass::Box& box, const std::function<bool(const float*)>& room);
// Eight grains a particle, at the corners of a cube about it, `offset` from its centre along each axis.
std::vector<float> grains_about(const std::vector<float>& particles, float offset);
// The points, moved.
std::vector<float> shifted(std::vector<float> points, float x, float y, float z);
// The particles `count` times, each time shifted by `offset` along every axis.
std::vector<float> copies(const std::vector<float>& particles, int count, float offset);

// Loose points as particles at rest, with eight grains each.
GranularScene loose_sand(const sandglass::Box& box, const std::function<bool(const float*)>& room);

// Distance between the points i and j.
double distance(const std::vector<float>& a, size_t i, const std::vector<float>& b, size_t j);
