// Sand with a skin, for its tests.
#pragma once

#include <gtest/gtest.h>

#include "tests/granular/granular_scene.h"

constexpr float k_radius = 0.01f;

inline sandglass_scene_desc rough(uint32_t particles) {
  sandglass_scene_desc desc = description(particles);
  desc.granular.static_friction = 0.6f;
  desc.granular.kinetic_friction = 0.55f;
  return desc;
}

struct Sand {
  explicit Sand(sandglass_scene_desc desc, uint32_t closed = 0) : scene(desc) {
    sandglass_skin_desc of_skin = sandglass::skin_desc(desc.granular);
    of_skin.closed = closed;
    accept(skin.create(of_skin));
  }

  sandglass_frame_report frame(float step = 0.02f) {
    sandglass_frame_input input = scene.input(step);
    input.skin = skin.get();
    return scene.run(input);
  }
  void until_asleep() {
    for (int i = 0; i < 900; ++i)
      if (frame().sand.awake == 0) return;
    ADD_FAILURE() << "it does not come to rest";
  }

  GranularScene scene;
  sandglass::Skin skin;
};
