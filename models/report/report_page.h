// The report of a run as a page: one HTML file that needs no network, with the pictures in it, the frames' times
// against the budget, quality, the ladder and the light as charts, and the numbers behind them as JSON. The charts are
// drawn by the page's own script (report_page.html) from the rows of report.csv, so the two cannot differ.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "models/report/report.h"

namespace sandglass::host {

using ImageFile = std::vector<uint8_t>;  // the bytes of a PNG or JPEG file

// One picture, or two of equal size that belong together, with a slider between them.
struct PageFigure {
  std::string title, caption;
  ImageFile picture;  // the left one
  ImageFile other;    // the right one; empty: a single picture
  std::string picture_label, other_label;
  bool wide = false;  // takes the whole width of the page
};

struct PageTable {
  std::string title, caption;
  std::vector<std::string> head;  // empty: a list of facts, of two columns
  std::vector<std::vector<std::string>> rows;
};

struct LightSample {
  double time = 0.0;                                                // seconds
  std::array<double, 3> direction = {};                             // towards the light, world; any length above 0
  std::array<double, 3> colour = {-1, 0, 0}, ambient = {-1, 0, 0};  // linear RGB, 0..1; first below 0: not known
};
struct LightSeries {
  std::string name;  // "labels"
  std::vector<LightSample> samples;
};

struct PageContent {
  std::string title;  // empty: the scene's name
  std::vector<PageFigure> figures;
  std::vector<PageTable> tables;
  std::vector<LightSeries> light;  // drawn beside that of the report's rows: what it should be, for example
};

// A Failure for a figure that is neither PNG nor JPEG.
std::string report_page(const RunReport& report, const PageContent& content);

// What this machine is: rows for a table of facts.
std::vector<std::vector<std::string>> machine_facts();

std::string base64(const std::vector<uint8_t>& bytes);

}  // namespace sandglass::host
