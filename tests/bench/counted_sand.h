// The sand that is counted: 1,560 particles that carry 27,000 grains. They collapse on a floor beside a box, and every
// frame does all of its work.
#pragma once

#include <vector>

#include "sandglass/sandglass.hpp"
#include "tests/bench/counting.h"

struct CountedSand {
  // `edge`: metres from one grain to the next. `more`: particles that there is room for beside those. `width`:
  // of the column of sand, metres.
  explicit CountedSand(sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC, sandglass_clock clock = {}, float edge = 0.0068f,
                       uint32_t more = 0, float width = 0.2f) {
    const float r = 0.01f;
    std::vector<float> particles, grains;
    const float half = 0.5f * width, high = width + r;
    const sandglass::Box box{{-half, r, -half}, {half, high, half}};
    const auto everywhere = [](const float*) { return true; };
    status = sandglass::sample_lattice(box, 2.02f * r, everywhere, &particles);
    // Grains on a lattice of their own, each shifted by a fraction of its cell.
    CountingRandom random;
    for (float y = r; y < high; y += edge)
      for (float z = -half; z < half; z += edge)
        for (float x = -half; x < half; x += edge)
          for (const float at : {x, y, z}) grains.push_back(at + 0.5f * edge * random());
    sandglass_scene_desc desc = sandglass::scene_desc();
    desc.isa = isa;
    desc.clock = clock;
    desc.granular.particle_radius = r;
    desc.granular.particle_capacity = static_cast<uint32_t>(particles.size() / 3) + more;
    desc.granular.grain_capacity = static_cast<uint32_t>(grains.size() / 3);
    desc.granular.collider_capacity = 2;
    desc.granular.emitter_capacity = more != 0 ? 1 : 0;
    if (status) status = scene.create(desc);
    if (status) status = scene.add(particles, grains);
    colliders[1].shape = SANDGLASS_SHAPE_BOX;
    colliders[1].position[0] = 0.2f;
    for (float& side : colliders[1].size) side = 0.08f;
    drawn.resize(desc.granular.grain_capacity);
    input.time_step = 0.016667f;
    input.budget_ns = ~0ull;
    input.colliders = colliders;
    input.collider_count = 2;
    input.grains = drawn.data();
    input.grain_capacity = desc.granular.grain_capacity;
  }
  CountedSand(const CountedSand&) = delete;
  CountedSand& operator=(const CountedSand&) = delete;

  sandglass::Status status;
  sandglass::Scene scene;
  sandglass_collider colliders[2] = {sandglass::floor_at(0.0f), sandglass::floor_at(0.0f)};
  std::vector<sandglass_grain> drawn;
  sandglass_frame_input input = sandglass::frame_input();
  sandglass_frame_report report = sandglass::frame_report();
};
