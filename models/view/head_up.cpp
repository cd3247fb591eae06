// See head_up.h.
#include "models/view/head_up.h"

#include <algorithm>
#include <cstdio>

#include "models/report/report.h"

namespace sandglass::host {

namespace {

constexpr int k_width = 440, k_height = 178, k_margin = k_panel_margin, k_line = k_panel_line, k_scale = k_panel_scale;
constexpr Colour k_paper = {24, 26, 30}, k_ink = {236, 233, 226}, k_faint = {160, 166, 174}, k_bad = {255, 107, 102},
                 k_trough = {52, 56, 63};

}  // namespace

Colour stage_colour(sandglass_stage stage) {
  constexpr Colour k_colours[SANDGLASS_STAGE_COUNT] = {
      {204, 130, 68}, {224, 112, 143}, {127, 146, 221}, {236, 197, 97}, {77, 184, 170}};
  return k_colours[stage];
}

BudgetBar budget_bar() { return {k_margin, 2 * k_line + k_margin, k_width - 2 * k_margin, 16, 300}; }

Picture head_up_panel(const HeadUp& state) {
  Picture panel(k_width, k_height, k_paper);
  const sandglass_frame_report& r = *state.report;
  char text[96];
  int line = 0;
  const auto write = [&](Colour colour) {
    draw_text(&panel, k_margin, k_margin + k_line * line++, k_scale, text, colour);
  };
  const double used = 1e-6 * static_cast<double>(r.elapsed_ns);
  std::snprintf(text, sizeof text, "%s  %.2f s%s", state.scene.c_str(), r.simulated_time,
                state.paused ? "  paused" : "");
  write(k_ink);
  std::snprintf(text, sizeof text, "budget %.2f ms  used %.2f", state.budget_ms, used);
  write(used > state.budget_ms ? k_bad : k_ink);

  const BudgetBar bar = budget_bar();
  fill_rectangle(&panel, bar.x, bar.y, bar.full_width, bar.height, k_trough);
  double from = 0.0;
  for (sandglass_stage stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) {
    const double to = from + 1e-6 * static_cast<double>(r.stages[stage].elapsed_ns) / std::max(1e-3, state.budget_ms);
    const auto pixel = [&](double share) {
      return static_cast<int>(std::min(static_cast<double>(bar.full_width), share * bar.budget_width) + 0.5);
    };
    fill_rectangle(&panel, bar.x + pixel(from), bar.y, pixel(to) - pixel(from), bar.height, stage_colour(stage));
    from = to;
  }
  fill_rectangle(&panel, bar.x + bar.budget_width, bar.y - 3, 2, bar.height + 6, k_ink);
  line = 3;
  int x = k_margin;
  for (sandglass_stage stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) {
    if (!state.runs[stage]) continue;
    draw_text(&panel, x, k_margin + k_line * line - 2, 1, stage_name(stage), stage_colour(stage));
    x += text_width(1, stage_name(stage)) + 14;
  }

  line = 4;
  const sandglass_level* described = sandglass_level_describe(r.level);
  std::snprintf(text, sizeof text, "quality %u: %s", r.level, described != nullptr ? described->name : "");
  write(r.level == SANDGLASS_LEVEL_SLOW_MOTION ? k_bad : k_ink);
  std::snprintf(text, sizeof text, "overlap p99 %.2f %% of r",
                described != nullptr ? 100.0 * static_cast<double>(described->overlap_p99) : 0.0);
  write(k_ink);
  std::snprintf(text, sizeof text, "time debt %.0f ms  shadows %u", 1e3 * r.time_debt, r.pending_shadows);
  write(r.time_debt > 0.001 ? k_bad : k_ink);
  std::snprintf(text, sizeof text, "%u particles %u grains  light %.0f/%.0f  %.0f fps", r.particles, r.grains,
                state.polar_deg, state.azimuth_deg, state.frames_per_second);
  draw_text(&panel, k_margin, k_margin + k_line * line++ + 2, 1, text, k_faint);
  return panel;
}

Picture key_help() {
  constexpr const char* k_text =
      "drag: turn   right drag: push   wheel: nearer   P: pour   arrows: light   - =: budget   G: particles   "
      "R: again   space: pause   Q: quit";
  Picture strip(text_width(1, k_text) + 2 * k_margin, 7 + 2 * 6, k_paper);
  draw_text(&strip, k_margin, 6, 1, k_text, k_faint);
  return strip;
}

}  // namespace sandglass::host
