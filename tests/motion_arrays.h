// The memory of a motion grid (kernels.h) outside a scene, for tests and counts of the kernels.
#pragma once

#include <algorithm>
#include <vector>

#include "runtime/sand/grains.h"

struct MotionArrays {
  explicit MotionArrays(uint32_t capacity) : slots(4 * capacity), blocks(capacity) {
    using namespace sandglass;
    planes.resize(capacity * k_block_floats / 16);
    nodes.resize(capacity * k_block_records * k_record_floats / 16);
    counts.resize(capacity * k_block_counts);
    uint32_t size = 1;
    while (2 * size <= slots.size()) size *= 2;
    grid.slots = slots.data();
    grid.slot_mask = size - 1;
    grid.blocks = blocks.data();
    grid.block_capacity = capacity;
    grid.planes = planes[0].values;
    grid.nodes = nodes[0].values;
    grid.counts = counts.data();
  }

  // What a scene does before grains are counted.
  void scatter(const sandglass::Kernels& kernels, const sandglass::Particle* particles, uint32_t count, float time) {
    std::fill(slots.begin(), slots.end(), 0u);
    grid.block_count = grid.overflowed = 0;
    const sandglass::ScatterMotionArgs args = {&grid, particles, count, time, nullptr, nullptr};
    uint32_t unused = 0;
    kernels.scatter_motion(&args, 0, (count + 15) / 16 * 16, &unused);
    for (uint32_t b = 0; b < grid.block_count; ++b) sandglass::motion_join(&grid, b);
  }

  struct alignas(64) Line {
    float values[16];
  };
  std::vector<uint32_t> slots;
  std::vector<sandglass::MotionBlock> blocks;
  std::vector<Line> planes, nodes;
  std::vector<uint8_t> counts;
  sandglass::MotionGrid grid = {};
};
