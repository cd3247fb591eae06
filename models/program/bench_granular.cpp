// `sandglass bench granular`: the column of 14,280 particles and 228,480 grains. It runs with the default scheme, with
// the dissertation's scheme, and with the dissertation's scheme at an equal error.
#include <algorithm>
#include <cstdio>
#include <thread>

#include "models/laboratory/sand/peer_bullet.h"
#include "models/program/bench.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_peer_frames = 5;     // other engines take seconds a frame
constexpr uint32_t k_search_threads = 4;  // the search needs only errors, which do not depend on threads

// Runs other engines, and ours for as many frames. In these the column still stands.
void run_peers(const SceneTable& table, const SceneFile& column, const Bench& bench) {
  if (!bullet_available()) {
    std::puts(
        "column14k/bullet: left out, this build has no Bullet. Install libbullet-dev, configure and build again.");
    return;
  }
  table.row("column14k/bullet, 5 frames", 1, k_peer_frames, "bullet",
            [&](const BenchStep& step) { return bench_bullet(column, k_peer_frames, step); });
  table.row("column14k/default, 5 frames", 1, k_peer_frames, bench.isa_name,
            [&](const BenchStep& step) { return bench_scene(column, bench.isa, 1, k_peer_frames, false, step); });
}

EqualError search_equal_error(const SceneFile& column, double p99, sandglass_isa isa, uint32_t frames) {
  constexpr uint32_t k_runs_at_most = 16;  // for all bisections; fewer if a cheap setting is found early
  const uint32_t threads = std::min(k_search_threads, std::max(1u, std::thread::hardware_concurrency()));
  Progress progress("searching source_equal_error", k_runs_at_most * frames);
  uint32_t frame = 0;
  return find_equal_error(column, p99, isa, threads, frames, [&] {
    progress.done(++frame);
    return !interrupted();
  });
}

}  // namespace

void bench_granular(const BenchOptions& options, Bench* bench) {
  constexpr uint32_t k_source_steps = 16, k_source_iterations = 7;  // algorithm 4 as the dissertation runs it
  const SceneFile column = load_scene("column14k");
  const SceneTable table(bench);
  BenchRow standard;
  for (const uint32_t threads : options.threads) {
    standard = table.row("column14k/default", column, threads, options.frames);
    table.row("column14k/source", source_scheme(column, k_source_steps, k_source_iterations), threads, options.frames);
    if (interrupted()) return;
  }
  if (options.peers) run_peers(table, column, *bench);
  if (interrupted()) return;
  const EqualError equal = search_equal_error(column, standard.overlap_p99, bench->isa, options.frames);
  if (interrupted()) return;
  if (!equal.found) {
    std::printf(
        "column14k/source_equal_error: no setting of the dissertation's scheme up to 256 steps x 7 iterations reaches "
        "a P99 of %.4f %% r\n",
        100.0 * standard.overlap_p99);
    return;
  }
  for (const uint32_t threads : options.threads)
    table.row("column14k/source_equal_error", source_scheme(column, equal.steps, equal.iterations), threads,
              options.frames);
  std::printf("source_equal_error is %u steps x %u iterations (+ 1 stabilisation)\n", equal.steps, equal.iterations);
  bench->keep("column14k/source_equal_error", "steps", "1/frame", equal.steps, options.threads[0]);
  bench->keep("column14k/source_equal_error", "iterations", "1/step", equal.iterations, options.threads[0]);
}

}  // namespace sandglass::host
