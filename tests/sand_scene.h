// A block of sand that falls onto a floor. Tests run it beside the work of another capability.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "sandglass/sandglass.hpp"

namespace sandglass::tests {

struct SandScene {
  explicit SandScene(sandglass_clock clock = {}, sandglass_log log = {}) {
    sandglass_scene_desc desc = scene_desc();
    desc.clock = clock;
    desc.log = log;
    desc.unit_items = 64;
    desc.granular.particle_capacity = desc.granular.grain_capacity = 600;
    EXPECT_TRUE(scene.create(desc));
    std::vector<float> particles, grains;
    for (int i = 0; i < 600; ++i)
      for (const float x : {0.0205f * static_cast<float>(i % 10), 0.02f + 0.0205f * static_cast<float>(i / 100),
                            0.0205f * static_cast<float>(i / 10 % 10)}) {
        particles.push_back(x);
        grains.push_back(x + 0.004f);
      }
    EXPECT_TRUE(scene.add(particles, grains));
  }

  // `input` has what the frame holds beside the sand.
  sandglass_frame_report frame(sandglass_frame_input input, uint64_t budget_ns) {
    const sandglass_collider floor = floor_at(0);
    input.time_step = 0.02f;
    input.budget_ns = budget_ns;
    input.colliders = &floor;
    input.collider_count = 1;
    sandglass_frame_report report = frame_report();
    status = scene.frame(input, &report).code;
    return report;
  }

  Scene scene;
  sandglass_status status = SANDGLASS_OK;
};

}  // namespace sandglass::tests
