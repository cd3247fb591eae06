// A small granular scene for tests: owns its block, its colliders and its grain buffer, and steps by whole frames.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sandglass/sandglass.h"

struct GranularScene {
  explicit GranularScene(const sandglass_scene_desc& desc);

  void add(const std::vector<float>& particles, const std::vector<float>& velocities = {},
           const std::vector<float>& grains = {});
  void add_floor(float height = 0.0f);

  // One frame; the budget is unlimited unless said otherwise.
  sandglass_frame_report frame(float time_step, uint64_t budget_ns = ~0ull >> 1, const sandglass_plan* plan = nullptr);

  std::vector<float> positions() const;
  std::vector<float> velocities() const;
  uint64_t hash() const { return sandglass_scene_hash(scene); }

  struct Free {
    void operator()(void* memory) const;
  };
  std::unique_ptr<void, Free> block;
  uint64_t bytes = 0;
  sandglass_scene* scene = nullptr;
  std::vector<sandglass_collider> colliders;
  std::vector<sandglass_grain> grains;
  uint32_t particle_count = 0;
};

// The defaults with room for this much, without a clock: every frame does all of its work.
sandglass_scene_desc description(uint32_t particles, uint32_t grains = 0, uint32_t boundary = 0);

sandglass_collider half_space(float height);

// A block of a cubic lattice standing on y = r: x * y * z particles at the given spacing, every other layer shifted by
// a quarter of it so that columns do not balance on their tips.
std::vector<float> lattice(uint32_t x, uint32_t y, uint32_t z, float spacing, float radius);
