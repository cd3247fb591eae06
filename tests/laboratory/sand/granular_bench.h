// The granular benchmark: the column of 14,280 particles and 228,480 grains, timed and measured in one run, so that
// time and error stand in one row.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "models/simulation/scene_file.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct BenchRow {
  // Means over the frames: CPU time of one thread, wall time of several.
  double ms_per_frame = 0.0, ms_solver = 0.0, ms_refine = 0.0;
  double overlap_p99 = 0.0, overlap_mean = 0.0, overlap_max = 0.0;
  double angle_deg = 0.0;
  uint64_t bytes = 0;  // of the scene's block
  uint32_t particles = 0, grains = 0, frames = 0;
};

// Called after each frame; false stops the run.
using BenchStep = std::function<bool()>;

// Runs the scene without a budget, at one quality level. `with_grains` false leaves the grains out: same particles,
// same errors, less time.
BenchRow bench_scene(SceneFile scene, sandglass_isa isa, uint32_t threads, uint32_t frames, bool with_grains,
                     const BenchStep& step, uint32_t level = SANDGLASS_LEVEL_FULL);

// The column with about so many particles, of the same proportions, and `grains_per_particle` grains each.
SceneFile scaled_column(const SceneFile& column, uint32_t particles, uint32_t grains_per_particle);

// Alg. 4 as printed: `steps` equal steps a frame, `iterations` solver iterations and one stabilisation each, averaged,
// relaxation 1.
SceneFile source_scheme(const SceneFile& scene, uint32_t steps, uint32_t iterations);

}  // namespace sandglass::host
