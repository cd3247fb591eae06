// Sand with a skin, and with a shadow where it is asked for, for its tests.
#pragma once

#include <gtest/gtest.h>

#include "tests/sand/granular_scene.h"

constexpr float k_radius = 0.01f;

inline sandglass_scene_desc rough(uint32_t particles) {
  sandglass_scene_desc desc = description(particles);
  desc.granular.static_friction = 0.6f;
  desc.granular.kinetic_friction = 0.55f;
  return desc;
}

inline std::vector<float> block(uint32_t x, uint32_t y, uint32_t z) {
  return lattice(x, y, z, 2.05f * k_radius, k_radius);
}

struct Sand {
  explicit Sand(sandglass_scene_desc desc, uint32_t closed = 0) : scene(desc) {
    sandglass_skin_desc of_skin = sandglass::skin_desc(desc.granular);
    of_skin.capped = closed;
    accept(skin.create(of_skin));
  }

  // On a floor.
  void lie(const std::vector<float>& points) {
    scene.add_floor();
    scene.add(points);
  }
  void throw_shadow() {
    sandglass_pile_shadow_desc desc = sandglass::pile_shadow_desc();
    desc.sky_texels = 64;
    accept(pile.create(desc));
  }

  sandglass_frame_report frame(float step = 0.02f, uint64_t budget_ns = ~0ull >> 1) {
    sandglass_frame_input input = scene.input(step, budget_ns);
    input.skin = skin.get();
    input.pile_shadow = pile.get();
    return scene.run(input);
  }
  // Until it has slept for some frames, and no shadow is behind.
  void until_rested() {
    for (int i = 0, rested = 0; i < 900; ++i) {
      const sandglass_frame_report report = frame();
      rested = report.sand.awake == 0 && report.stages[SANDGLASS_STAGE_SHADOW].units == 0 ? rested + 1 : 0;
      if (rested == 4) return;
    }
    ADD_FAILURE() << "it does not come to rest";
  }

  GranularScene scene;
  sandglass::Skin skin;
  sandglass::PileShadow pile;
};
