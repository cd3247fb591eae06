// Draws a measured curve beside its law: points and lines in a frame with ticks, labels and a legend. Axes are linear
// or logarithmic, and edges are smooth. It needs only the picture writer.
#pragma once

#include <string>
#include <vector>

#include "models/files/image.h"

namespace sandglass::host {

struct PlotAxis {
  std::string label;
  double low = 0.0, high = 1.0;  // the range shown; a logarithmic axis needs both above 0
  bool logarithmic = false;
};

struct PlotSeries {
  enum class Mark { none, disk, ring, square };
  std::string name;  // in the legend; empty: the legend leaves it out
  std::vector<double> x, y;
  Colour colour = {0, 0, 0};
  Mark mark = Mark::disk;
  bool line = false;
  bool dashed = false;
};

struct Plot {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
  bool legend_right = false;  // in the lower right corner instead of the upper left
};

Picture draw_plot(const Plot& plot);

// The labelled ticks of an axis, all within its range. On a linear axis they are multiples of 1, 2 or 5 times a power
// of ten, with at most eight steps. On a logarithmic axis of less than two decades they are 1, 2, 3 and 5 times the
// powers of ten, on a longer one the powers of ten.
std::vector<double> plot_ticks(const PlotAxis& axis);

}  // namespace sandglass::host
