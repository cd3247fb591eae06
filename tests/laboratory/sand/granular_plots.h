// The curves of `verify granular` beside their laws.
#pragma once

#include <string>
#include <vector>

#include "models/drawing/plot.h"
#include "tests/laboratory/sand/granular_verdicts.h"

namespace sandglass::host {

struct GranularPlot {
  std::string name;  // of the file, without its ending
  Plot plot;
};

// Those for which there are points: "runout", "discharge".
std::vector<GranularPlot> granular_plots(const GranularCurves& curves);

}  // namespace sandglass::host
