// What the viewer writes over the scene: the budget bar of the last frame by stage, quality with its error, the time
// debt, and what the keys do; as pictures that the window lays over its own.
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

// Lines of text, from the panel's upper left corner, pixels: 1 is the budget, 4 the quality, 5 its error.
constexpr int k_panel_margin = 10, k_panel_line = 20, k_panel_scale = 2;
Picture head_up_panel(const HeadUp& state);
Picture key_help();

// The bar's place in the panel, pixels: `budget_width` is as long as the budget, of `full_width` that can be drawn.
struct BudgetBar {
  int x, y, full_width, height, budget_width;
};
BudgetBar budget_bar();
Colour stage_colour(sandglass_stage stage);

}  // namespace sandglass::host
