// A measured curve beside its law: points and lines in a frame with ticks, labels and a legend, linear or logarithmic
// axes, drawn with smooth edges. Needs nothing but the picture writer.
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
  std::string name;  // in the legend; empty: not listed
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

// Where an axis has its labelled ticks: multiples of 1, 2 or 5 times a power of ten, at most eight; on a logarithmic
// axis of less than two decades 1, 2, 3, 5 in each, else the decades. Within the range.
std::vector<double> plot_ticks(const PlotAxis& axis);

}  // namespace sandglass::host
