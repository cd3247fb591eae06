// The pictures that the viewer lays over the scene: the budget bar of the last frame by stage, the quality level with
// its error, the time debt, and what the keys do.
#pragma once

#include "models/files/image.h"
#include "sandglass/sandglass.h"

namespace sandglass::host {

struct HeadUp {
  std::string scene;
  const sandglass_frame_report* report = nullptr;
  double budget_ms = 0.0, frames_per_second = 0.0, polar_deg = 0.0, azimuth_deg = 0.0;
  bool paused = false;
  bool runs[SANDGLASS_STAGE_COUNT] = {true, true, true, true, true};  // the stages that the legend names
};

// The panel's margin and height of a line, in pixels, and the text's scale. Counted from 0, line 1 is the budget, line
// 4 the quality level, line 5 its error.
constexpr int k_panel_margin = 10, k_panel_line = 20, k_panel_scale = 2;
Picture head_up_panel(const HeadUp& state);
Picture key_help();

// The bar's place in the panel, in pixels. `budget_width` stands for the whole budget; the bar can grow to
// `full_width`.
struct BudgetBar {
  int x, y, full_width, height, budget_width;
};
BudgetBar budget_bar();
Colour stage_colour(sandglass_stage stage);

}  // namespace sandglass::host
