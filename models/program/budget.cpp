// `sandglass budget`: what a scene's frames cost on phones at each quality level, when all their work is done. The costs
// are estimates (models/phones).
#include <algorithm>
#include <cstdio>

#include "models/program/commands.h"
#include "models/program/run.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

struct BudgetOptions {
  std::string scene, mesh;
  uint32_t frames = 0;  // 0: the scene's
};

Options options_of(BudgetOptions& o) {
  return {
      required({"SCENE", &o.scene, "", k_scene_argument}),
      {"--mesh", &o.mesh, "FILE", k_body_mesh},
      standard(k_scene, {"--frames", &o.frames, "N", "Frames to run", whole_number(1, 100'000'000)}),
  };
}

constexpr double k_no_limit_ms = 1e6;
// The governor keeps some of a budget free, so that the last work unit and the output fit.
constexpr double k_used_of_a_budget = 0.9;

// Instructions a frame. Max: what all frames but one in a thousand need at most, or all where they are too few to tell.
struct LevelCost {
  double mean = 0.0, max = 0.0;
};

}  // namespace

static int run(const BudgetOptions& options) {
  RunOptions run_options;
  run_options.scene = options.scene;
  run_options.mesh = options.mesh;
  run_options.frames = options.frames;
  run_options.budget_ms = k_no_limit_ms;
  run_options.as = phone_cores().front().name;  // instructions are those of every core
  const PhoneCore& counted = phone_cores().front();
  std::vector<LevelCost> levels;
  std::map<std::string, uint64_t> guessed;
  std::string scene;
  uint32_t particles = 0, grains = 0;
  size_t frames = 0;
  bool has_p999 = false;
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_COUNT && !interrupted(); ++level) {
    Run run(run_options, level);
    run.execute();
    const Distribution elapsed = summarise(run.report().frames).elapsed;
    const double per_ms = counted.ghz * 1e6 * counted.middle_ipc();
    levels.push_back({elapsed.mean * per_ms, elapsed.p999.value_or(elapsed.max) * per_ms});
    has_p999 = elapsed.p999.has_value();
    guessed = run.phone()->guessed();
    scene = run.report().scene;
    frames = run.report().frames.size();
    if (frames == 0) break;
    const sandglass_sand_report& sand = run.report().frames.back().report.sand;
    particles = sand.particles;
    grains = sand.grains;
  }
  if (interrupted()) return k_exit_interrupted;

  std::printf("%s: %u particles, %u grains, %zu frames with all their work\n", scene.c_str(), particles, grains,
              frames);
  std::printf(
      "Estimated from counted NEON instructions, not measured. Times are for a stated range of instructions a "
      "cycle.\n");
  std::printf("\n%-32s %21s", "quality level", has_p999 ? "M instructions, 99.9 %" : "M instructions, most");
  for (const PhoneCore& core : phone_cores()) std::printf("  %16s", core.name);
  std::printf("\n");
  for (uint32_t level = 0; level < levels.size(); ++level) {
    std::printf("%-32s %10.1f %11.1f", level_text(level).c_str(), levels[level].mean * 1e-6, levels[level].max * 1e-6);
    for (const PhoneCore& core : phone_cores()) {
      char cell[48];
      std::snprintf(cell, sizeof cell, "%.1f to %.1f ms",
                    core.ms(levels[level].max, core.ipc_high) / k_used_of_a_budget,
                    core.ms(levels[level].max, core.ipc_low) / k_used_of_a_budget);
      std::printf("  %16s", cell);
    }
    std::printf("\n");
  }
  std::printf("\nA budget in which %s do all their work, with a tenth that the governor keeps free.\n",
              has_p999 ? "99.9 % of the frames" : "all of these frames");
  for (const PhoneCore& core : phone_cores())
    std::printf("%s: %.1f GHz, %.1f to %.1f instructions a cycle; %s\n", core.name, core.ghz, core.ipc_low,
                core.ipc_high, core.why);
  for (const auto& [name, units] : guessed)
    std::printf("not counted, taken as 20,000 instructions each: %s, %llu units\n", name.c_str(),
                static_cast<unsigned long long>(units));
  return k_exit_done;
}

Command budget_command() {
  return command<BudgetOptions>("budget", "Estimate the budget that a scene needs on a phone, at each quality level",
                                options_of, run);
}

}  // namespace sandglass::host
