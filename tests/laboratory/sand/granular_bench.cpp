// Times and errors of the column. Errors are measured between frames and are not part of the times.
#include "tests/laboratory/sand/granular_bench.h"

#include <algorithm>
#include <cmath>

#include "models/simulation/metrics.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/simulation.h"
#include "models/work/thread_pool.h"
#include "platform/clock.h"

namespace sandglass::host {

BenchRow bench_scene(SceneFile scene, sandglass_isa isa, uint32_t threads, uint32_t frames, bool with_grains,
                     const BenchStep& step, uint32_t level) {
  if (!with_grains)
    for (Body& body : scene.bodies) {
      body.grains = 0;
      body.grain_distance = 0.0;
    }
  const Material material = fill_scene(&scene, {});
  sandglass_scene_desc desc = describe_scene(scene, material.particles(), material.grains());
  ThreadPool pool(threads);
  desc.isa = isa;
  // With one thread the clock is its CPU time, so other programs on the machine do not count. For several threads there
  // is no such clock.
  desc.clock = threads == 1 ? clock_thread_cpu() : sandglass_clock_system();
  desc.parallel = pool.hook();
  desc.finest_level = level;
  Simulation simulation(desc);
  simulation.add(material);

  BenchRow row;
  row.bytes = simulation.bytes();
  row.particles = material.particles();
  row.grains = material.grains();
  OverlapOverRun overlap;
  for (uint32_t frame = 0; frame < frames; ++frame) {
    const sandglass_frame_report report =
        simulation.frame(scene.frame_step, UINT64_MAX, colliders_over_frame(scene, frame));
    row.ms_per_frame += static_cast<double>(report.time.elapsed_ns) * 1e-6;
    row.ms_solver += static_cast<double>(report.stages[SANDGLASS_STAGE_GRANULAR].elapsed_ns) * 1e-6;
    row.ms_refine += static_cast<double>(report.stages[SANDGLASS_STAGE_REFINE].elapsed_ns) * 1e-6;
    overlap.add(measure_overlap(simulation.particle_positions(), scene.particle_radius));
    ++row.frames;
    if (!step()) break;
  }
  for (double* total : {&row.ms_per_frame, &row.ms_solver, &row.ms_refine}) *total /= row.frames;
  row.overlap_p99 = overlap.p99();
  row.overlap_mean = overlap.mean();
  row.overlap_max = overlap.max;
  row.angle_deg = measure_pile(simulation.particle_positions(), scene.particle_radius).angle_deg;
  return row;
}

// A factor just above 1 on the exact share of the frame, so that rounding does not add a step.
constexpr double k_rounding = 1.0 + 1e-5;

SceneFile scaled_column(const SceneFile& column, uint32_t particles, uint32_t grains_per_particle) {
  SceneFile changed = column;
  Body& body = changed.bodies.at(0);
  const double now = static_cast<double>(body.counts[0]) * body.counts[1] * body.counts[2];
  const double scale = std::cbrt(particles / now);
  for (uint32_t& count : body.counts) count = std::max(1u, static_cast<uint32_t>(std::lround(count * scale)));
  body.grains = body.counts[0] * body.counts[1] * body.counts[2] * grains_per_particle;
  return changed;
}

SceneFile source_scheme(const SceneFile& scene, uint32_t steps, uint32_t iterations) {
  SceneFile changed = scene;
  changed.granular.reference.scheme = SANDGLASS_SCHEME_AVERAGED;
  changed.granular.reference.relaxation = 1.0f;
  changed.granular.height_weighting = 0.6f;  // (4.38)
  changed.granular.reference.solver_iterations = iterations;
  changed.granular.reference.stabilisation_iterations = 1;
  changed.granular.substep_max = changed.granular.substep_min =
      static_cast<float>(scene.frame_step / steps * k_rounding);
  return changed;
}

}  // namespace sandglass::host
